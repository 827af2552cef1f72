//! Any renderer, by the command template of `validation/renderers.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use serde::Deserialize;
use validation::converge::Picture;
use validation::image;

/// One line of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Renderer {
    /// Program and arguments with words in braces to be filled in.
    pub command: String,
}

/// What to render.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    pub scene: &'a Path,
    pub samples: u32,
    pub seed: u32,
    /// 0: all.
    pub threads: usize,
}

/// The committed file.
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../renderers.toml")
}

/// All renderers of a file, by name.
pub fn load(path: &Path) -> Result<BTreeMap<String, Renderer>, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    toml::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))
}

impl Renderer {
    /// Renders to the file `out` and reads it: the picture, and the seconds without start-up.
    pub fn render(&self, job: &Job, out: &Path) -> Result<(Picture, f64), String> {
        let words = validation::peer::words(&self.command).ok_or("a quote of the command is not closed")?;
        let words: Vec<String> = words.iter().map(|word| fill(word, job, out)).collect();
        let (program, arguments) = words.split_first().ok_or("the command is empty")?;
        // A stale file must not pass for the answer.
        if out.exists() {
            std::fs::remove_file(out).map_err(|e| format!("{}: {e}", out.display()))?;
        }
        let start = Instant::now();
        let output = Command::new(sibling(program))
            .args(arguments)
            .output()
            .map_err(|e| format!("{program:?} does not start: {e}"))?;
        let wall = start.elapsed().as_secs_f64();
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            let last = text.lines().rev().find(|l| !l.trim().is_empty()).unwrap_or("it said nothing");
            return Err(format!("{program:?} failed ({}): {}", output.status, last.trim()));
        }
        let seconds = reported(&String::from_utf8_lossy(&output.stdout)).unwrap_or(wall);
        let found = image::load(out).map_err(|e| e.to_string())?;
        let named = |name: &str| found.channels.iter().find(|c| c.name == name);
        let channels: Option<Vec<_>> = ["R", "G", "B"].into_iter().map(named).collect();
        let channels = channels.ok_or_else(|| format!("{}: there are no channels R, G, B", out.display()))?;
        let picture: Picture = channels.iter().flat_map(|c| c.mean.iter().copied()).collect();
        if picture.iter().all(|v| v.is_finite()) {
            Ok((picture, seconds))
        } else {
            Err(format!("{program:?} made values that are not finite"))
        }
    }
}

fn fill(word: &str, job: &Job, out: &Path) -> String {
    let peers = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers");
    word.replace("{scene}", &job.scene.to_string_lossy())
        .replace("{out}", &out.to_string_lossy())
        .replace("{spp}", &job.samples.to_string())
        .replace("{seed}", &job.seed.to_string())
        .replace("{threads}", &job.threads.to_string())
        .replace("{peers}", &peers.to_string_lossy())
}

/// A program of this workspace is the one built beside this one.
fn sibling(program: &str) -> PathBuf {
    let beside = std::env::current_exe().ok().map(|exe| exe.with_file_name(program));
    beside.filter(|path| path.is_file()).unwrap_or_else(|| program.into())
}

/// "seconds" of the JSON at the end of standard output: the last line, or a whole document.
fn reported(text: &str) -> Option<f64> {
    let read = |text: &str| serde_json::from_str::<serde_json::Value>(text).ok();
    let document = text.lines().last().and_then(read).or_else(|| read(text))?;
    document.get("seconds")?.as_f64().filter(|s| *s > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_file_is_read() {
        let all = load(&file()).unwrap();
        assert_eq!(all.keys().filter(|name| name.starts_with("mitsuba-")).count(), 4);
        assert!(
            all.values()
                .all(|r| ["{scene}", "{out}", "{spp}", "{seed}"].iter().all(|w| r.command.contains(w)))
        );
    }

    #[test]
    fn a_missing_program_and_a_failing_one_are_errors() {
        let job = Job { scene: Path::new("a b.xml"), samples: 1, seed: 7, threads: 0 };
        let out = std::env::temp_dir().join("etalon-no-such-picture.exr");
        let error = |command: &str| Renderer { command: command.into() }.render(&job, &out).unwrap_err();
        assert!(error("no-such-renderer {out}").contains("does not start"));
        assert!(error("").contains("empty"));
        assert_eq!(fill("x{scene}:{seed}", &job, &out), "xa b.xml:7");
    }

    #[test]
    fn seconds_are_found_at_the_end() {
        assert_eq!(reported("noise\n{\"seconds\": 1.5, \"startup\": 9}\n"), Some(1.5));
        assert_eq!(reported("{\n\"seconds\": 2\n}\n"), Some(2.0));
        assert_eq!(reported("done"), None);
    }
}
