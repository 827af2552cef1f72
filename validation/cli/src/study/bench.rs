//! Renders the missing pictures of a study of a scene, and keeps everything in a folder, so that it can be
//! interrupted at any time.
//!
//! - `origin.json`: the scene file and the command of each renderer, which must stay the same;
//! - `schedule.json`: each renderer's sample counts, or why it cannot render the scene;
//! - `references/`: the pictures of each renderer's converged mean;
//! - `runs.jsonl`: a line for every picture, in the order of rendering;
//! - `pictures/`: the pictures of the longest rung of the first seed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use validation::converge::{Errors, Picture, Reference, errors, reference, without_each};

use super::{Ladder, REFERENCES, Run, Settings, seed};
use crate::console;
use crate::files;
use crate::renderers::{Job, Rendered, Renderers, Took, mean_of, read};
use crate::report::machine;

/// A renderer's sample counts, one per rung, or why it has none.
pub type Schedule = BTreeMap<String, Result<Vec<u32>, String>>;

/// What a folder's pictures are of.
#[derive(Default, Serialize, Deserialize)]
struct Origin {
    /// The scene file.
    scene: Option<String>,
    commands: BTreeMap<String, String>,
}

/// What a renderer's pictures are held against.
struct Mean {
    /// The pictures that it is the mean of.
    of: Vec<Picture>,
    reference: Reference,
}

impl Mean {
    /// The errors of a picture against the mean, and against those of all its pictures but one. `None` if their sizes
    /// differ.
    fn errors(&self, picture: &Picture) -> Option<(Errors, Vec<Errors>)> {
        let without = without_each(&self.of);
        Some((
            errors(picture, &self.reference)?,
            without.iter().filter_map(|of| errors(picture, of)).collect(),
        ))
    }
}

/// The folder of a scene, with the study's renderers and settings.
pub struct Bench<'a> {
    /// The scene file that all renderers render.
    pub scene: PathBuf,
    pub folder: PathBuf,
    pub renderers: &'a Renderers,
    pub settings: &'a Settings,
    /// How long one picture may take.
    pub limit: Option<Duration>,
}

impl Bench<'_> {
    /// Measures what is missing, and says which renderers failed after they had once succeeded, with the
    /// reason; what is measured of them and of others is kept. A renderer that cannot render the scene is
    /// noted in the schedule. Error: an unusable folder.
    pub fn measure(&self, names: &[&str], progress: &dyn Fn(&str)) -> Result<Vec<(String, String)>, String> {
        for folder in ["references", "pictures"] {
            std::fs::create_dir_all(self.folder.join(folder)).map_err(|e| e.to_string())?;
        }
        self.check_origin(names)?;
        let mut schedule = self.schedule()?;
        let (mut tried, mut references) = (BTreeSet::new(), BTreeMap::new());
        for name in names {
            let of = mean_of(self.renderers, name);
            for name in [name, of] {
                // A renderer that failed in an earlier run may have been installed since.
                if !matches!(schedule.get(name), Some(Ok(_))) && tried.insert(name) {
                    progress(&format!("{name}: pilot"));
                    schedule.insert(name.to_string(), self.counts(name));
                    self.keep("schedule.json", &schedule)?;
                }
            }
            let (Ok(_), Ok(counts)) = (&schedule[*name], &schedule[of]) else { continue };
            if !references.contains_key(of) {
                progress(&format!("{of}: reference"));
                let longest = counts.last().copied().unwrap_or(1);
                let found = self
                    .reference(of, (f64::from(longest) * self.settings.reference).round() as u32)
                    .and_then(|found| self.has_size_of(of, names).map(|()| found));
                match found {
                    Ok(found) => drop(references.insert(of, found)),
                    Err(why) => drop(schedule.insert(of.to_string(), Err(why))),
                }
            }
        }
        self.keep("schedule.json", &schedule)?;
        self.runs_missing(names, &schedule, &references, progress)
    }

    /// Renders the missing runs, alternating between renderers (A B A B), so that changes of the machine's
    /// load affect all.
    fn runs_missing(
        &self,
        names: &[&str],
        schedule: &Schedule,
        references: &BTreeMap<&str, Mean>,
        progress: &dyn Fn(&str),
    ) -> Result<Vec<(String, String)>, String> {
        let mut failed: Vec<(String, String)> = vec![];
        let (done, mut added) = (self.runs()?, vec![]);
        let last = self.settings.ladder.count() - 1;
        for k in 0..self.settings.seeds {
            for rung in 0..=last {
                for &name in names {
                    let reference = references.get(mean_of(self.renderers, name));
                    let (Some(Ok(counts)), Some(reference)) = (schedule.get(name), reference) else {
                        continue;
                    };
                    if done.iter().any(|r| (r.renderer.as_str(), r.seed, r.rung) == (name, k, rung)) {
                        continue;
                    }
                    if failed.iter().any(|(of, _)| of == name) {
                        continue;
                    }
                    progress(&format!("{name}: seed {k}, rung {rung}"));
                    let known = done.iter().chain(&added);
                    match self.run_once(name, k, (rung, counts[rung]), reference, known) {
                        Ok(run) => {
                            if k == 0 && rung == last {
                                let kept = self.folder.join("pictures").join(format!("{name}.exr"));
                                std::fs::rename(self.out(), kept).map_err(|e| e.to_string())?;
                            }
                            self.add(&run)?;
                            added.push(run);
                        }
                        Err(why) => {
                            let why = format!("seed {k}, {} samples: {why}", counts[rung]);
                            progress(&format!("{name}: {why}"));
                            failed.push((name.to_string(), why));
                        }
                    }
                }
            }
        }
        Ok(failed)
    }

    /// Renders one picture of a rung, with so many samples. Error: the renderer's, or that the picture is that of
    /// another number of samples among the `known` runs.
    fn run_once<'r>(
        &self,
        name: &str,
        seed: u32,
        (rung, samples): (usize, u32),
        reference: &Mean,
        mut known: impl Iterator<Item = &'r Run>,
    ) -> Result<Run, String> {
        let (took, (errors, without)) = self.picture(name, (samples, seed), reference)?;
        let same = |run: &&Run| {
            (run.renderer.as_str(), run.seed, run.errors) == (name, seed, errors) && run.samples != samples
        };
        if let Some(Run { samples, .. }) = known.find(same) {
            return Err(format!("its picture is that of {samples} samples: their number has no effect"));
        }
        let with = machine::in_short();
        Ok(Run { renderer: name.to_string(), seed, rung, samples, took, errors, without, with })
    }

    /// Keeps what the folder's pictures are of. Error: it holds pictures of another scene, or of a renderer with
    /// another command.
    fn check_origin(&self, names: &[&str]) -> Result<(), String> {
        let file = self.folder.join("origin.json");
        let mut kept: Origin = if file.is_file() { files::json(&file)? } else { Origin::default() };
        let text = std::fs::read(&self.scene).map_err(|e| format!("{}: {e}", self.scene.display()))?;
        let scene = String::from_utf8_lossy(&text).into_owned();
        let folder = self.folder.display();
        if kept.scene.as_ref().is_some_and(|kept| *kept != scene) {
            return Err(format!(
                "{folder} holds pictures of another scene; choose another folder, or remove it"
            ));
        }
        kept.scene = Some(scene);
        // Those that only make references for others count as well.
        for name in names.iter().flat_map(|name| [*name, mean_of(self.renderers, name)]) {
            let Some(renderer) = self.renderers.get(name) else { continue };
            let command = kept.commands.entry(name.to_owned()).or_insert_with(|| renderer.command.clone());
            if *command != renderer.command {
                return Err(format!(
                    "{folder} holds pictures of {name} by another command, `{command}`; choose another folder, or remove it"
                ));
            }
        }
        self.keep("origin.json", &kept)
    }

    /// Whether a renderer's reference has the size of that of the first which has one.
    fn has_size_of(&self, name: &str, names: &[&str]) -> Result<(), String> {
        let size = |name: &str| {
            let file = self.reference_file(name, 0);
            Ok::<_, String>(if file.is_file() { Some(read(&file)?).map(|(_, w, h)| (w, h)) } else { None })
        };
        for first in names.iter().map(|first| mean_of(self.renderers, first)) {
            if let (Some((width, height)), Some(own)) = (size(first)?, size(name)?) {
                return if own == (width, height) {
                    Ok(())
                } else {
                    Err(format!(
                        "its pictures have {} × {} pixels, those of {first} {width} × {height}",
                        own.0, own.1
                    ))
                };
            }
        }
        Ok(())
    }

    /// A picture of so many samples, by number. Error: it cannot be rendered, or is not of the reference's size.
    fn picture(
        &self,
        name: &str,
        (samples, k): (u32, u32),
        of: &Mean,
    ) -> Result<(Took, (Errors, Vec<Errors>)), String> {
        let found = self.render(name, samples, seed("picture", k))?;
        let errors = of.errors(&found.picture).ok_or("its pictures differ in size")?;
        Ok((found.took, errors))
    }

    /// All finished runs.
    pub fn runs(&self) -> Result<Vec<Run>, String> {
        let file = self.folder.join("runs.jsonl");
        // The picture of a line that an interruption cut off is rendered again.
        if file.exists() { files::lines(&file, "a finished run") } else { Ok(vec![]) }
    }

    /// The schedule so far; empty at first.
    pub fn schedule(&self) -> Result<Schedule, String> {
        let file = self.folder.join("schedule.json");
        if !file.exists() {
            return Ok(Schedule::new());
        }
        files::json(&file)
    }

    /// The mean of the renderer's stored reference pictures; `None` with fewer than two.
    pub fn stored_reference(&self, name: &str) -> Result<Option<Reference>, String> {
        Ok(reference(&self.stored_pictures(name)?))
    }

    /// The mean of all values of each of a renderer's reference pictures.
    pub fn reference_means(&self, name: &str) -> Result<Vec<f64>, String> {
        let mean = |picture: &Picture| picture.iter().sum::<f64>() / picture.len() as f64;
        Ok(self.stored_pictures(name)?.iter().map(mean).collect())
    }

    fn stored_pictures(&self, name: &str) -> Result<Vec<Picture>, String> {
        let files = (0..REFERENCES).map(|k| self.reference_file(name, k)).filter(|file| file.is_file());
        files.map(|file| Ok(read(&file)?.0)).collect()
    }

    /// The sample count of each rung. Error: the renderer cannot render the scene.
    fn counts(&self, name: &str) -> Result<Vec<u32>, String> {
        match &self.settings.ladder {
            Ladder::Seconds(seconds) => self.pilot(name, seconds),
            // A trial with one sample, which fails if the renderer cannot render the scene.
            Ladder::Samples(samples) => self.render(name, 1, seed("trial", 0)).map(|_| samples.clone()),
        }
    }

    fn pilot(&self, name: &str, ladder: &[f64]) -> Result<Vec<u32>, String> {
        // Seconds of planning, which do not depend on samples, and of samples.
        let look = |samples: u32| {
            let took = self.render(name, samples, seed("pilot", samples))?.took;
            Ok::<_, String>(took.parts(self.settings.processor_time))
        };
        let (first, last) = (ladder[0], ladder[ladder.len() - 1]);
        // In the first picture programs and kernels are not cached yet.
        let (_, cold) = look(4)?;
        let (planning, warm) = look(4)?;
        let few = cold.min(warm);
        // A rate measured with few samples is unreliable for many, and what else the machine does only makes it less.
        let more = (4.0 * (0.5 * first / few).clamp(1.0, 1024.0)) as u32;
        let mut rate = 4.0 / few;
        if more > 8 {
            let looks = (0..3).map(|_| Ok(look(more)?.1)).collect::<Result<Vec<f64>, String>>()?;
            rate = f64::from(more) / looks.into_iter().fold(f64::INFINITY, f64::min);
        }
        if (last - planning) * rate < 1.0 {
            let sample = 1.0 / rate;
            return Err(format!(
                "planning and a sample take {:.1} s, longer than the longest rung",
                planning + sample
            ));
        }
        let count = |wanted: &f64| {
            let exponent = libm::log2(((wanted - planning) * rate).max(1.0)).round().min(24.0);
            1u32 << exponent as u32
        };
        Ok(ladder.iter().map(count).collect())
    }

    fn reference(&self, name: &str, samples: u32) -> Result<Mean, String> {
        for k in 0..REFERENCES {
            let kept = self.reference_file(name, k);
            if !kept.is_file() {
                self.render(name, samples, seed("reference", k))?;
                std::fs::rename(self.out(), kept).map_err(|e| e.to_string())?;
            }
        }
        let pictures = self.stored_pictures(name)?;
        if pictures.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(
                "its pictures of different seeds are the same: the seed has no effect, or there is no \
                        noise whose error could be measured"
                    .into(),
            );
        }
        let reference = reference(&pictures).ok_or("its pictures differ in size")?;
        Ok(Mean { of: pictures, reference })
    }

    fn reference_file(&self, name: &str, k: u32) -> PathBuf {
        self.folder.join("references").join(format!("{name}-{k}.exr"))
    }

    fn render(&self, name: &str, samples: u32, seed: u32) -> Result<Rendered, String> {
        let renderer = self.renderers.get(name).ok_or_else(|| format!("there is no renderer {name:?}"))?;
        let Settings { threads, .. } = *self.settings;
        let job = Job { threads, limit: self.limit, ..Job::new(&self.scene, samples, seed) };
        renderer.render(&job, &self.out())
    }

    fn out(&self) -> PathBuf {
        self.folder.join("picture.exr")
    }

    fn keep(&self, name: &str, what: &impl Serialize) -> Result<(), String> {
        let text = || Ok(validation::report::to_json(what)?);
        console::write(Some(&self.folder.join(name)), text).map_err(|e| e.to_string())
    }

    fn add(&self, run: &Run) -> Result<(), String> {
        let file = self.folder.join("runs.jsonl");
        let line = serde_json::to_string(run).map_err(|e| e.to_string())?;
        files::append(&file, &line)
    }
}

#[cfg(test)]
mod tests;
