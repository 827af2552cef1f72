//! Renders what a scene of the table lacks yet, and keeps everything in a folder, so that it can be stopped
//! at any time.
//!
//! - `scene.xml`: the scene as all render it;
//! - `schedule.json`: the sample counts that take each renderer the seconds asked for, and who cannot render
//!   it;
//! - `references/`: the pictures of each renderer's converged mean;
//! - `runs.jsonl`: a line for every picture, in the order of rendering;
//! - `pictures/`: the longest rung of the first seed.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::{Deserialize, Serialize};
use validation::converge::{Errors, Picture, Reference, errors, reference};

use super::plan::{Entry, Plan};
use crate::console;
use crate::converge::{REFERENCES, seed};
use crate::renderers::{Job, Rendered, Renderers, mean_of, read};

/// How long to look.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Settings {
    /// Seconds of each rung.
    pub seconds: Vec<f64>,
    pub seeds: u32,
    /// Samples of a reference's picture over those of the longest rung.
    pub reference: u32,
    pub threads: usize,
    /// Seconds are those of the processor, for machines that do other things meanwhile.
    pub processor_time: bool,
}

/// A renderer's sample counts, one a rung, or why it has none.
pub type Schedule = BTreeMap<String, Result<Vec<u32>, String>>;

/// One picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    pub renderer: String,
    pub seed: u32,
    pub rung: usize,
    pub samples: u32,
    pub seconds: f64,
    pub cpu_seconds: f64,
    pub startup: f64,
    pub errors: Errors,
}

/// A scene's folder.
pub struct Bench<'a> {
    pub folder: PathBuf,
    pub renderers: &'a Renderers,
    pub settings: &'a Settings,
}

impl Bench<'_> {
    /// Measures what is missing. Fails where nothing at all can be measured.
    pub fn measure(
        &self,
        entry: &Entry,
        plan: &Plan,
        shared: &Path,
        progress: &dyn Fn(&str),
    ) -> Result<(), String> {
        for folder in ["references", "pictures"] {
            std::fs::create_dir_all(self.folder.join(folder)).map_err(|e| e.to_string())?;
        }
        self.prepare(entry, &entry.path(shared))?;
        let mut schedule = self.schedule()?;
        let mut references = BTreeMap::new();
        for name in plan.renderers() {
            let of = mean_of(self.renderers, name);
            for name in [name, of] {
                if !matches!(schedule.get(name), Some(Ok(_))) {
                    progress(&format!("{}: {name}: pilot", entry.name));
                    schedule.insert(name.to_string(), self.pilot(name));
                    self.keep("schedule.json", &schedule)?;
                }
            }
            let (Ok(_), Ok(counts)) = (&schedule[name], &schedule[of]) else { continue };
            if !references.contains_key(of) {
                progress(&format!("{}: {of}: reference", entry.name));
                let longest = counts.last().copied().unwrap_or(1);
                match self.reference(of, longest.saturating_mul(self.settings.reference)) {
                    Ok(found) => drop(references.insert(of, found)),
                    Err(why) => drop(schedule.insert(of.to_string(), Err(why))),
                }
            }
        }
        self.keep("schedule.json", &schedule)?;
        self.runs_missing(entry, plan, &schedule, &references, progress)
    }

    /// A B A B: whatever the machine does meanwhile, it does to all.
    fn runs_missing(
        &self,
        entry: &Entry,
        plan: &Plan,
        schedule: &Schedule,
        references: &BTreeMap<&str, Reference>,
        progress: &dyn Fn(&str),
    ) -> Result<(), String> {
        let done = self.runs()?;
        let last = self.settings.seconds.len() - 1;
        for k in 0..self.settings.seeds {
            for rung in 0..=last {
                for name in plan.renderers() {
                    let reference = references.get(mean_of(self.renderers, name));
                    let (Some(Ok(counts)), Some(reference)) = (schedule.get(name), reference) else {
                        continue;
                    };
                    if done.iter().any(|r| (&r.renderer, r.seed, r.rung) == (name, k, rung)) {
                        continue;
                    }
                    progress(&format!("{}: {name}: seed {k}, rung {rung}", entry.name));
                    let found = self.render(name, counts[rung], seed("picture", k))?;
                    if found.picture.len() != reference.mean.len() {
                        return Err(format!("{name}: its pictures differ in size"));
                    }
                    if k == 0 && rung == last {
                        let kept = self.folder.join("pictures").join(format!("{name}.exr"));
                        std::fs::rename(self.out(), kept).map_err(|e| e.to_string())?;
                    }
                    self.add(&Run {
                        renderer: name.clone(),
                        seed: k,
                        rung,
                        samples: counts[rung],
                        seconds: found.took.seconds,
                        cpu_seconds: found.took.cpu_seconds,
                        startup: found.took.startup,
                        errors: errors(&found.picture, reference),
                    })?;
                }
            }
        }
        Ok(())
    }

    /// What was rendered.
    pub fn runs(&self) -> Result<Vec<Run>, String> {
        let file = self.folder.join("runs.jsonl");
        let text = if file.exists() { std::fs::read_to_string(&file) } else { Ok(String::new()) };
        let text = text.map_err(|e| format!("{}: {e}", file.display()))?;
        // A line that was cut off by an interruption is rendered again.
        Ok(text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
    }

    /// Who renders how much; empty at first.
    pub fn schedule(&self) -> Result<Schedule, String> {
        let file = self.folder.join("schedule.json");
        if !file.exists() {
            return Ok(Schedule::new());
        }
        let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        serde_json::from_str(&text).map_err(|e| format!("{}: {e}", file.display()))
    }

    /// The mean of a renderer's reference pictures, of those that are there.
    pub fn stored_reference(&self, name: &str) -> Result<Option<Reference>, String> {
        let files = (0..REFERENCES).map(|k| self.reference_file(name, k)).filter(|file| file.is_file());
        let pictures: Result<Vec<Picture>, String> = files.map(|file| Ok(read(&file)?.0)).collect();
        Ok(reference(&pictures?))
    }

    fn prepare(&self, entry: &Entry, source: &Path) -> Result<(), String> {
        if !source.is_file() {
            return Err(format!("there is no {}", source.display()));
        }
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers/prepare_scene.py");
        let size = format!("{}x{}", entry.size[0], entry.size[1]);
        let mut command = Command::new("python3");
        command.arg(script).arg(source).arg(self.folder.join("scene.xml")).arg(size);
        let output = command.output().map_err(|e| format!("python3: {e}"))?;
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.success() { Ok(()) } else { Err(said.lines().last().unwrap_or("").to_string()) }
    }

    fn pilot(&self, name: &str) -> Result<Vec<u32>, String> {
        let seconds =
            |samples: u32| self.render(name, samples, seed("pilot", samples)).map(|r| self.time(&r));
        let (first, last) =
            (self.settings.seconds[0], self.settings.seconds[self.settings.seconds.len() - 1]);
        // The first picture finds programs and kernels cold.
        let few = seconds(4)?.min(seconds(4)?);
        // Few samples say little of a rate that must hold for many.
        let more = (4.0 * (0.5 * first / few).clamp(1.0, 1024.0)) as u32;
        let rate = if more > 8 { f64::from(more) / seconds(more)? } else { 4.0 / few };
        if last * rate < 1.0 {
            return Err(format!("a sample takes {:.1} s, longer than the longest rung", 1.0 / rate));
        }
        let count = |wanted: &f64| {
            let exponent = libm::log2((wanted * rate).max(1.0)).round().min(24.0);
            1u32 << exponent as u32
        };
        Ok(self.settings.seconds.iter().map(count).collect())
    }

    fn reference(&self, name: &str, samples: u32) -> Result<Reference, String> {
        for k in 0..REFERENCES {
            let kept = self.reference_file(name, k);
            if !kept.is_file() {
                self.render(name, samples, seed("reference", k))?;
                std::fs::rename(self.out(), kept).map_err(|e| e.to_string())?;
            }
        }
        self.stored_reference(name)?.ok_or_else(|| "its pictures differ in size".into())
    }

    fn reference_file(&self, name: &str, k: u32) -> PathBuf {
        self.folder.join("references").join(format!("{name}-{k}.exr"))
    }

    fn render(&self, name: &str, samples: u32, seed: u32) -> Result<Rendered, String> {
        let renderer = self.renderers.get(name).ok_or_else(|| format!("there is no renderer {name:?}"))?;
        let scene = self.folder.join("scene.xml");
        let job = Job { scene: &scene, samples, seed, threads: self.settings.threads };
        renderer.render(&job, &self.out())
    }

    fn out(&self) -> PathBuf {
        self.folder.join("picture.exr")
    }

    /// The seconds that count.
    pub fn time(&self, found: &Rendered) -> f64 {
        if self.settings.processor_time { found.took.cpu_seconds } else { found.took.seconds }
    }

    fn keep(&self, name: &str, schedule: &Schedule) -> Result<(), String> {
        let text = || Ok(validation::report::to_json(schedule)?);
        console::write(Some(&self.folder.join(name)), text).map_err(|e| e.to_string())
    }

    fn add(&self, run: &Run) -> Result<(), String> {
        let file = self.folder.join("runs.jsonl");
        let line = serde_json::to_string(run).map_err(|e| e.to_string())? + "\n";
        let open = std::fs::OpenOptions::new().create(true).append(true).open(&file);
        let written = open.and_then(|mut opened| opened.write_all(line.as_bytes()));
        written.map_err(|e| format!("{}: {e}", file.display()))
    }
}
