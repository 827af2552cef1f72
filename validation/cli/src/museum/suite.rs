//! The suite as the museum runs it: program after program, up to the first failure.

use super::cargo::Program;
use super::findings::Fate;
use super::plant::VARIABLE;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Memory a program may take, in KiB: a bug may ask for all there is.
const MEMORY: &str = "8388608";
/// A test that says nothing for so long does not end.
const PATIENCE: Duration = Duration::from_secs(600);

/// How a program ended.
#[derive(Clone, Debug, PartialEq)]
enum End {
    Passed,
    /// The first test that failed.
    Failed(String),
    /// No test had failed when the program did, or had to be stopped.
    Broken(&'static str),
}

/// All test programs, with what they have cost and what they have found.
pub struct Suite {
    stages: Vec<Stage>,
    jobs: usize,
    /// Tests that fail without any bug, and so prove nothing.
    unfit: Vec<String>,
}

struct Stage {
    program: Program,
    /// Time spent on the bugs of each module, and how many were found.
    record: BTreeMap<String, (Duration, u32)>,
}

impl Stage {
    fn cost(&self, module: &str) -> Duration {
        self.record.get(module).map_or(Duration::ZERO, |(spent, kills)| *spent / (kills + 1))
    }
}

impl Suite {
    pub fn new(programs: Vec<Program>, jobs: usize) -> Self {
        let stage = |program| Stage { program, record: BTreeMap::new() };
        // Cargo names the renderer's first, but those of the harness ask about light.
        Self { stages: programs.into_iter().rev().map(stage).collect(), jobs, unfit: vec![] }
    }

    /// Lets bug number `bug`, which is in `file`, out on the suite. First come all tests that bear the name of the
    /// file or of its module, then all, in the order of what a find in this module has cost so far.
    /// With `near`, only the former; `None` if these do not notice.
    pub fn judge(&mut self, bug: usize, file: &str, near: bool) -> Result<Option<Fate>, String> {
        let start = Instant::now();
        let [module, name] = names(file);
        self.stages.sort_by_key(|stage| stage.cost(&module));
        let filters = [Some(name), Some(format!("{module}::")), None];
        for filter in filters.into_iter().take(if near { 2 } else { 3 }) {
            let filter: Vec<String> = filter.into_iter().collect();
            for stage in &mut self.stages {
                let before = Instant::now();
                let end = failure(&stage.program, &filter, bug, self.jobs, &mut self.unfit)?;
                let (spent, kills) = stage.record.entry(module.clone()).or_default();
                *spent += before.elapsed();
                let Some(test) = end else { continue };
                *kills += 1;
                let program = stage.program.name.clone();
                let seconds = start.elapsed().as_secs_f64().round();
                return Ok(Some(Fate::Killed { program, test, seconds }));
            }
        }
        Ok((!near).then_some(Fate::Survived))
    }
}

/// Module and name of a source file as tests bear them: `bsdf` and `plastic` of `src/bsdf/plastic.rs`.
fn names(file: &str) -> [String; 2] {
    let mut parts: Vec<&str> = file.trim_start_matches("src/").trim_end_matches(".rs").split('/').collect();
    if parts.len() > 1 && parts.last() == Some(&"mod") {
        parts.pop();
    }
    [parts[0].to_owned(), parts[parts.len() - 1].to_owned()]
}

/// The test that fails with the bug and does not without it.
fn failure(
    program: &Program,
    filter: &[String],
    bug: usize,
    jobs: usize,
    unfit: &mut Vec<String>,
) -> Result<Option<String>, String> {
    loop {
        let skipped = unfit.iter().flat_map(|test| ["--skip".to_owned(), test.clone()]);
        let arguments: Vec<String> = filter.iter().cloned().chain(skipped).collect();
        let (test, alone) = match run(program, &arguments, bug, jobs)? {
            End::Passed => return Ok(None),
            End::Failed(test) => (test.clone(), vec!["--exact".to_owned(), test]),
            End::Broken(how) => (how.to_owned(), arguments),
        };
        match run(program, &alone, 0, jobs)? {
            End::Passed => return Ok(Some(test)),
            End::Failed(same) if same == test => {
                eprintln!("{test} of {} fails without any bug", program.name);
                unfit.push(test);
            }
            _ => return Err(format!("{} breaks without any bug", program.name)),
        }
    }
}

fn run(program: &Program, arguments: &[String], bug: usize, jobs: usize) -> Result<End, String> {
    let mut child = Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY}; exec nice -n 15 \"$0\" \"$@\"")])
        .arg(&program.path)
        .args(arguments)
        .args(["--test-threads", &jobs.to_string()])
        .env(VARIABLE, bug.to_string())
        .env("RAYON_NUM_THREADS", jobs.to_string())
        .current_dir(&program.folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|e| format!("{}: {e}", program.path.display()))?;
    let lines = lines_of(&mut child);
    let end = watch(&lines, PATIENCE);
    if end.is_some() {
        // What else fails is of no interest.
        child.kill().ok();
    }
    let status = child.wait().map_err(|e| e.to_string())?;
    Ok(match end {
        Some(end) => end,
        None if status.success() => End::Passed,
        None => End::Broken("a crash"),
    })
}

fn lines_of(child: &mut Child) -> Receiver<String> {
    let (sender, lines) = channel();
    if let Some(output) = child.stdout.take() {
        std::thread::spawn(move || {
            BufReader::new(output).lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
    }
    lines
}

/// Reads until a test fails or nothing is said for too long; `None` at the end of the output.
fn watch(lines: &Receiver<String>, patience: Duration) -> Option<End> {
    loop {
        match lines.recv_timeout(patience) {
            Ok(line) => {
                if let Some(test) = failed(&line) {
                    return Some(End::Failed(test.to_owned()));
                }
            }
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) => return Some(End::Broken("no end")),
        }
    }
}

/// The test that a line of a test program's output says has failed.
fn failed(line: &str) -> Option<&str> {
    let (name, result) = line.strip_prefix("test ")?.rsplit_once(" ... ")?;
    let name = name.strip_suffix(" - should panic").unwrap_or(name);
    result.trim_start().starts_with("FAILED").then(|| name.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_read_from_lines() {
        assert_eq!(failed("test bsdf::contract::finite ... FAILED"), Some("bsdf::contract::finite"));
        assert_eq!(failed("test plastic[0]::chi2::75   ... FAILED"), Some("plastic[0]::chi2::75"));
        assert_eq!(failed("test bsdf::contract::finite ... ok"), None);
        assert_eq!(failed("test result: FAILED. 3 passed; 1 failed"), None);
        assert_eq!(failed("FAILED"), None);
    }

    #[test]
    fn files_name_their_tests() {
        assert_eq!(names("src/bsdf/plastic.rs"), ["bsdf", "plastic"]);
        assert_eq!(names("src/shape/accel/mod.rs"), ["shape", "accel"]);
        assert_eq!(names("src/lib.rs"), ["lib", "lib"]);
    }

    #[test]
    fn silence_is_no_end() {
        let (sender, lines) = channel();
        assert_eq!(watch(&lines, Duration::ZERO), Some(End::Broken("no end")));
        sender.send("test a ... FAILED".into()).unwrap();
        assert_eq!(watch(&lines, PATIENCE), Some(End::Failed("a".into())));
        drop(sender);
        assert_eq!(watch(&lines, PATIENCE), None);
    }
}
