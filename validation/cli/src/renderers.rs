//! Any renderer, by a command template of `validation/renderers.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use validation::converge::Picture;
use validation::image;

/// An entry of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Renderer {
    /// Program and arguments, with placeholders in braces.
    pub command: String,
    /// Another renderer whose pictures have the same mean, and whose converged mean is therefore the
    /// reference of this one, which may not converge in any feasible time. By default its own converged mean
    /// is the reference.
    pub mean_of: Option<String>,
}

/// A scene to render, with its sample count, seed and threads.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    pub scene: &'a Path,
    /// Samples per pixel.
    pub samples: u32,
    pub seed: u32,
    /// Number of threads; 0 means all.
    pub threads: usize,
}

/// Times of a render in seconds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Took {
    /// Wall-clock time of rendering, without start-up and planning.
    pub seconds: f64,
    /// Wall-clock time of planning how to render the scene, which does not depend on the number of samples.
    pub planning: f64,
    /// Processor time of planning and rendering on all threads; of the whole process where the renderer does
    /// not report it.
    pub cpu_seconds: f64,
    /// Wall-clock time before and after planning and rendering.
    pub startup: f64,
}

impl Took {
    /// Seconds of planning and of samples that are compared. On a machine with other load they are processor
    /// time, of which the part of planning is unknown and therefore 0.
    pub fn parts(&self, processor_time: bool) -> (f64, f64) {
        if processor_time { (0.0, self.cpu_seconds) } else { (self.planning, self.seconds) }
    }

    /// The sum of both parts.
    pub fn counted(&self, processor_time: bool) -> f64 {
        let (planning, samples) = self.parts(processor_time);
        planning + samples
    }
}

/// A rendered picture.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Red, green and blue one after the other, each in row-major order.
    pub picture: Picture,
    pub width: usize,
    pub height: usize,
    pub took: Took,
}

/// The committed file.
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../renderers.toml")
}

/// All renderers of a file, by name.
pub type Renderers = BTreeMap<String, Renderer>;

/// Reads a file of renderers.
pub fn load(path: &Path) -> Result<Renderers, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let all: Renderers = toml::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let stranger = |renderer: &Renderer| renderer.mean_of.clone().filter(|name| !all.contains_key(name));
    let fault = |renderer: &Renderer| match stranger(renderer) {
        Some(stranger) => Some(format!("there is no renderer {stranger:?}")),
        None => fault_of(&renderer.command),
    };
    match all.iter().find_map(|(name, renderer)| Some((name, fault(renderer)?))) {
        Some((name, fault)) => Err(format!("{}: {name}: {fault}", path.display())),
        None => Ok(all),
    }
}

/// What is wrong with the placeholders of a command: one that has no meaning would be handed on as it
/// stands, and a misspelt seed would be the same for every picture.
fn fault_of(command: &str) -> Option<String> {
    let names = command.split('{').skip(1).filter_map(|rest| Some(rest.split_once('}')?.0));
    let is_name = |name: &&str| name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
    let stranger = names.filter(is_name).find(|name| !PLACEHOLDERS.contains(name));
    if let Some(stranger) = stranger {
        return Some(format!(
            "{{{stranger}}} is no placeholder, expected one of {{{}}}",
            PLACEHOLDERS.join("}, {")
        ));
    }
    (!command.contains("{out}")).then(|| "its command has no {out}, the file to write".into())
}

/// What may stand in braces in a command, besides `env:NAME:default`; [`fill`] has the values.
const PLACEHOLDERS: [&str; 6] = ["scene", "out", "spp", "seed", "threads", "peers"];

/// The renderer whose converged mean is the reference of `name`.
pub fn mean_of<'a>(all: &'a Renderers, name: &'a str) -> &'a str {
    all.get(name).and_then(|renderer| renderer.mean_of.as_deref()).unwrap_or(name)
}

impl Renderer {
    /// Renders to the file `out` and reads its colours. Errors: those of [`Self::run`], or a file without
    /// finite R, G, B.
    pub fn render(&self, job: &Job, out: &Path) -> Result<Rendered, String> {
        let took = self.run(job, out)?;
        let (picture, width, height) = read(out)?;
        Ok(Rendered { picture, width, height, took })
    }

    /// Renders to the file `out`. Errors: the program does not start or fails; the message has its last
    /// words.
    pub fn run(&self, job: &Job, out: &Path) -> Result<Took, String> {
        let command = from_environment(&self.command)?;
        let words = validation::peer::words(&command).ok_or("a quote of the command is not closed")?;
        let words: Vec<String> = words.iter().map(|word| fill(word, job, out)).collect();
        let (program, arguments) = words.split_first().ok_or("the command is empty")?;
        // A file of an earlier render must not pass for the result.
        if out.exists() {
            std::fs::remove_file(out).map_err(|e| format!("{}: {e}", out.display()))?;
        }
        let (start, busy) = (Instant::now(), children_seconds());
        let output = Command::new(sibling(program))
            .args(arguments)
            .output()
            .map_err(|e| format!("{program:?} does not start: {e}"))?;
        let (wall, cpu) = (start.elapsed().as_secs_f64(), children_seconds() - busy);
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            let last = text.lines().rev().find(|l| !l.trim().is_empty()).unwrap_or("it said nothing");
            return Err(format!("{program:?} failed ({}): {}", output.status, last.trim()));
        }
        if !out.exists() {
            return Err(format!("{program:?} ended well, but wrote no {}", out.display()));
        }
        let said = Said::of(&String::from_utf8_lossy(&output.stdout))?;
        let seconds = said.seconds.unwrap_or(wall);
        let planning = said.planning.unwrap_or(0.0);
        let cpu_seconds = said.cpu_seconds.unwrap_or(cpu.max(1e-3));
        Ok(Took { seconds, planning, cpu_seconds, startup: (wall - planning - seconds).max(0.0) })
    }
}

/// Channels R, G and B of an OpenEXR file, and its width and height.
pub fn read(file: &Path) -> Result<(Picture, usize, usize), String> {
    let found = image::load(file).map_err(|e| e.to_string())?;
    let named = |name: &str| found.channels.iter().find(|c| c.name == name);
    let channels: Option<Vec<_>> = ["R", "G", "B"].into_iter().map(named).collect();
    let channels = channels.ok_or_else(|| format!("{}: there are no channels R, G, B", file.display()))?;
    let picture: Picture = channels.iter().flat_map(|c| c.mean.iter().copied()).collect();
    if picture.iter().all(|v| v.is_finite()) {
        Ok((picture, found.width, found.height))
    } else {
        Err(format!("{}: not all values are finite", file.display()))
    }
}

/// Replaces `{env:NAME:default}` by the value of the environment variable `NAME`.
fn from_environment(command: &str) -> Result<String, String> {
    let mut parts = command.split("{env:");
    let mut filled = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (inside, rest) = part.split_once('}').ok_or("a brace of the command is not closed")?;
        let (name, default) = inside.split_once(':').unwrap_or((inside, ""));
        filled += &std::env::var(name).unwrap_or_else(|_| default.into());
        filled += rest;
    }
    Ok(filled)
}

/// Processor time of the children that have ended, in seconds; 0 where the system does not report it. Linux
/// counts it in hundredths (`proc(5)`, fields 16 and 17 of `stat`); the name of the program, in parentheses,
/// may contain spaces.
fn children_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let fields = after.split_whitespace().skip(13).take(2);
    fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn fill(word: &str, job: &Job, out: &Path) -> String {
    let peers = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers");
    let path = |path: &Path| path.to_string_lossy().into_owned();
    let [samples, seed] = [job.samples, job.seed].map(|n| n.to_string());
    let values = [path(job.scene), path(out), samples, seed, job.threads.to_string(), path(&peers)];
    let put = |word: String, (name, value): (&&str, String)| word.replace(&format!("{{{name}}}"), &value);
    PLACEHOLDERS.iter().zip(values).fold(word.to_owned(), put)
}

/// The program of this name in the folder of this one, if it exists there; otherwise it is searched on the
/// path.
fn sibling(program: &str) -> PathBuf {
    let beside = std::env::current_exe().ok().map(|exe| exe.with_file_name(program));
    beside.filter(|path| path.is_file()).unwrap_or_else(|| program.into())
}

/// Times from the JSON at the end of standard output: on the last line that is JSON, or the whole output.
#[derive(Debug, Default, PartialEq)]
struct Said {
    seconds: Option<f64>,
    planning: Option<f64>,
    cpu_seconds: Option<f64>,
}

impl Said {
    /// Error: a time that is none.
    fn of(text: &str) -> Result<Said, String> {
        let read =
            |text: &str| serde_json::from_str::<serde_json::Value>(text).ok().filter(|v| v.is_object());
        let Some(document) = text.lines().rev().find_map(read).or_else(|| read(text)) else {
            return Ok(Said::default());
        };
        let number = |name: &str, is_time: fn(f64) -> bool| match document.get(name) {
            None => Ok(None),
            Some(value) => match value.as_f64().filter(|s| is_time(*s)) {
                Some(seconds) => Ok(Some(seconds)),
                None => Err(format!("it says {name:?}: {value}, which is no time")),
            },
        };
        Ok(Said {
            seconds: number("seconds", |s| s > 0.0)?,
            planning: number("plan_seconds", |s| s >= 0.0)?,
            // A clock of hundredths may say that nothing passed.
            cpu_seconds: number("cpu_seconds", |s| s >= 0.0)?.filter(|s| *s > 0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_file_is_read() {
        let all = load(&file()).unwrap();
        assert_eq!(all.keys().filter(|name| name.starts_with("mitsuba-")).count(), 12);
        assert!(
            all.values()
                .all(|r| ["{scene}", "{out}", "{spp}", "{seed}"].iter().all(|w| r.command.contains(w)))
        );
    }

    #[test]
    fn means_of_others_are_those_of_known_renderers() {
        let file = std::env::temp_dir().join(format!("etalon-renderers-{}.toml", std::process::id()));
        let read =
            |text: &str| std::fs::write(&file, text).map_err(|e| e.to_string()).and_then(|()| load(&file));
        let all = read("[a]\ncommand = \"x {out}\"\nmean_of = \"b\"\n[b]\ncommand = \"y {out}\"").unwrap();
        assert_eq!(["a", "b", "c"].map(|name| mean_of(&all, name)), ["b", "b", "c"]);
        let refused = read("[a]\ncommand = \"x\"\nmean_of = \"b\"").unwrap_err();
        assert!(refused.ends_with("a: there is no renderer \"b\""), "{refused}");
        for (command, fault) in [
            ("x {out} {sed}", "{sed} is no placeholder, expected one of {scene}, {out}"),
            ("x {seed} > {env:OUT:y}", "no {out}"),
        ] {
            let refused = read(&format!("[a]\ncommand = \"{command}\"")).unwrap_err();
            assert!(refused.contains(fault), "{refused}");
        }
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn a_missing_program_and_a_failing_one_are_errors() {
        let job = Job { scene: Path::new("a b.xml"), samples: 1, seed: 7, threads: 0 };
        let out = std::env::temp_dir().join("etalon-no-such-picture.exr");
        let error = |command: &str| {
            Renderer { command: command.into(), mean_of: None }.render(&job, &out).unwrap_err()
        };
        assert!(error("no-such-renderer {out}").contains("does not start"));
        assert!(error("").contains("empty"));
        assert_eq!(fill("x{scene}:{seed}", &job, &out), "xa b.xml:7");
    }

    #[test]
    fn seconds_are_found_at_the_end() {
        let said = |text: &str| Said::of(text).unwrap().seconds;
        assert_eq!(said("noise\n{\"seconds\": 1.5, \"startup\": 9}\n"), Some(1.5));
        assert_eq!(said("{\"seconds\": 1.5}\nlast words\n"), Some(1.5));
        assert_eq!(said("{\n\"seconds\": 2\n}\n"), Some(2.0));
        assert_eq!(Said::of("{\"seconds\": 1.5, \"plan_seconds\": 0.25}").unwrap().planning, Some(0.25));
        assert_eq!(said("done"), None);
        for wrong in ["-1", "0", "\"fast\"", "null"] {
            let error = Said::of(&format!("{{\"seconds\": {wrong}}}")).unwrap_err();
            assert_eq!(error, format!("it says \"seconds\": {wrong}, which is no time"));
        }
    }

    #[test]
    fn the_environment_fills_in() {
        assert_eq!(from_environment("{env:ETALON_NO_SUCH:python3} x").unwrap(), "python3 x");
        assert_eq!(
            from_environment("a {env:CARGO_PKG_NAME:b} c").unwrap(),
            format!("a {} c", env!("CARGO_PKG_NAME"))
        );
        assert!(from_environment("{env:open").is_err());
    }

    #[test]
    fn a_childs_work_is_counted() {
        let before = children_seconds();
        let work = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        assert!(Command::new("sh").args(["-c", work]).status().unwrap().success());
        assert!(children_seconds() > before);
    }
}
