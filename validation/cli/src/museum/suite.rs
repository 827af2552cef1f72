//! Runs the test suite on a bug: one program after the other, until the first failure.

use super::cargo::Program;
use super::findings::Fate;
use super::plant::{Change, VARIABLE};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Memory limit of a program in KiB: a bug may allocate without bound.
const MEMORY: &str = "8388608";
/// Time without output after which a test counts as endless.
const PATIENCE: Duration = Duration::from_secs(600);

/// Time limits of a program in successive rounds: a bug that one program detects late, another one mostly
/// detects early.
const ROUNDS: [Duration; 3] = [Duration::from_secs(10), Duration::from_secs(100), Duration::MAX];

/// How a program ended.
#[derive(Clone, Debug, PartialEq)]
enum End {
    Passed,
    /// The first test that failed.
    Failed(String),
    /// The program crashed or had to be stopped before any test had failed.
    Broken(&'static str),
    /// Its time limit was reached.
    Unfinished,
}

/// Which tests are run on a bug.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// Tests whose names contain the name of the bug's file, of its chapter of the catalogue or of a folder
    /// of the file.
    Near,
    /// Tests whose names contain this.
    Named(String),
    /// The near tests, then all others.
    All,
}

impl Asked {
    /// Filters of tests by name, in their order; an empty filter selects all.
    fn filters(&self, change: &Change) -> Vec<Vec<String>> {
        if let Self::Named(name) = self {
            return vec![vec![name.clone()]];
        }
        let mut folders = names(&change.file);
        let mut near = Vec::from_iter(folders.pop());
        near.extend(change.chapter.clone());
        near.extend(folders.iter().rev().map(|folder| format!("{folder}::")));
        let all = (*self == Self::All).then(Vec::new);
        near.into_iter().map(|name| vec![name]).chain(all).collect()
    }
}

/// The result of running a program on a bug.
enum Search {
    Found(String),
    Nothing,
    Unfinished,
}

/// All test programs, with their run times and finds so far.
pub struct Suite {
    stages: Vec<Stage>,
    jobs: usize,
    /// Tests that fail without any bug, and are therefore skipped.
    unfit: Vec<String>,
}

struct Stage {
    program: Program,
    /// For each module the time spent on its bugs and the number of finds; the totals are under [`ALL`].
    record: BTreeMap<String, (Duration, u32)>,
}

/// The key of the totals over all modules.
const ALL: &str = "";

impl Stage {
    /// Estimated time per find in this module; if there is no record of the module, over all modules.
    fn cost(&self, module: &str) -> Duration {
        let known = self.record.get(module).or_else(|| self.record.get(ALL));
        known.map_or(Duration::ZERO, |(spent, kills)| *spent / (kills + 1))
    }

    fn note(&mut self, module: &str, time: Duration, found: bool) {
        for name in [module, ALL] {
            let (spent, kills) = self.record.entry(name.to_owned()).or_default();
            *spent += time;
            *kills += u32::from(found);
        }
    }
}

impl Suite {
    pub fn new(programs: Vec<Program>, jobs: usize) -> Self {
        let stage = |program| Stage { program, record: BTreeMap::new() };
        // Cargo lists the renderer's programs first, but those of the harness test light transport.
        Self { stages: programs.into_iter().rev().map(stage).collect(), jobs, unfit: vec![] }
    }

    /// Runs the suite with bug number `bug` active: first all near tests, then all, ordered by the estimated
    /// time per find in this module. `None` if not all tests were to be run, and none of these detects the
    /// bug.
    pub fn judge(&mut self, bug: usize, change: &Change, asked: &Asked) -> Result<Option<Fate>, String> {
        let start = Instant::now();
        let module = names(&change.file).swap_remove(0);
        self.stages.sort_by_key(|stage| stage.cost(&module));
        let filters = asked.filters(change);
        for filter in filters {
            let mut open: Vec<usize> = (0..self.stages.len()).collect();
            for time in ROUNDS {
                let mut unfinished = vec![];
                for index in open {
                    let stage = &mut self.stages[index];
                    let before = Instant::now();
                    let end = search(&stage.program, &filter, bug, (self.jobs, time), &mut self.unfit)?;
                    stage.note(&module, before.elapsed(), matches!(end, Search::Found(_)));
                    match end {
                        Search::Nothing => {}
                        Search::Unfinished => unfinished.push(index),
                        Search::Found(test) => {
                            let program = stage.program.name.clone();
                            let seconds = start.elapsed().as_secs_f64().round();
                            return Ok(Some(Fate::Killed { program, test, seconds }));
                        }
                    }
                }
                open = unfinished;
            }
        }
        Ok((*asked == Asked::All).then_some(Fate::Survived))
    }
}

/// Folders and name of a source file as they occur in names of tests: `bsdf` and `plastic` for
/// `src/bsdf/plastic.rs`.
fn names(file: &str) -> Vec<String> {
    let mut parts: Vec<&str> = file.trim_start_matches("src/").trim_end_matches(".rs").split('/').collect();
    if parts.len() > 1 && parts.last() == Some(&"mod") {
        parts.pop();
    }
    parts.into_iter().map(str::to_owned).collect()
}

/// Searches for a test that fails with the bug and passes without it.
fn search(
    program: &Program,
    filter: &[String],
    bug: usize,
    (jobs, time): (usize, Duration),
    unfit: &mut Vec<String>,
) -> Result<Search, String> {
    loop {
        let skipped = unfit.iter().flat_map(|test| ["--skip".to_owned(), test.clone()]);
        let arguments: Vec<String> = filter.iter().cloned().chain(skipped).collect();
        let (test, alone) = match run(program, &arguments, bug, (jobs, time))? {
            End::Passed => return Ok(Search::Nothing),
            End::Unfinished => return Ok(Search::Unfinished),
            End::Failed(test) => (test.clone(), vec!["--exact".to_owned(), test]),
            End::Broken(how) => (how.to_owned(), arguments),
        };
        match run(program, &alone, 0, (jobs, Duration::MAX))? {
            End::Passed => return Ok(Search::Found(test)),
            End::Failed(same) if same == test => {
                eprintln!("{test} of {} fails without any bug", program.name);
                unfit.push(test);
            }
            _ => return Err(format!("{} breaks without any bug", program.name)),
        }
    }
}

fn run(
    program: &Program,
    arguments: &[String],
    bug: usize,
    (jobs, time): (usize, Duration),
) -> Result<End, String> {
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
    let end = watch(&lines, PATIENCE, time);
    if end.is_some() {
        // Further failures do not matter.
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

/// Reads until a test fails, there is no output for too long, or the time limit is reached; `None` at the end
/// of the output.
fn watch(lines: &Receiver<String>, patience: Duration, time: Duration) -> Option<End> {
    let begin = Instant::now();
    loop {
        let left = time.saturating_sub(begin.elapsed());
        match lines.recv_timeout(patience.min(left)) {
            Ok(line) => {
                if let Some(test) = failed(&line) {
                    return Some(End::Failed(test.to_owned()));
                }
            }
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) if left <= patience => return Some(End::Unfinished),
            Err(RecvTimeoutError::Timeout) => return Some(End::Broken("no end")),
        }
    }
}

/// The failed test that a line of a test program's output reports, if any.
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
    fn what_is_near_comes_before_all_else() {
        let change = Change {
            name: String::new(),
            about: String::new(),
            source: String::new(),
            file: "src/bsdf/plastic.rs".into(),
            chapter: Some("texture".into()),
            range: 0..0,
            replace: String::new(),
        };
        let near: [Vec<String>; 3] = ["plastic", "texture", "bsdf::"].map(|name| vec![name.into()]);
        assert_eq!(Asked::Near.filters(&change), near);
        assert_eq!(Asked::All.filters(&change), [&near[..], &[vec![]]].concat());
        assert_eq!(Asked::Named("a".into()).filters(&change), [["a"]]);
    }

    #[test]
    fn files_name_their_tests() {
        assert_eq!(names("src/bsdf/plastic.rs"), ["bsdf", "plastic"]);
        assert_eq!(names("src/shape/accel/mod.rs"), ["shape", "accel"]);
        assert_eq!(names("src/integrator/path/reuse/part.rs"), ["integrator", "path", "reuse", "part"]);
        assert_eq!(names("src/lib.rs"), ["lib"]);
    }

    #[test]
    fn a_new_module_begins_with_what_is_known_of_the_others() {
        let program = Program { name: String::new(), path: "a".into(), folder: "b".into() };
        let mut stage = Stage { program, record: BTreeMap::new() };
        assert_eq!(stage.cost("bsdf"), Duration::ZERO);
        stage.note("bsdf", Duration::from_secs(8), true);
        assert_eq!(stage.cost("film"), Duration::from_secs(4));
        stage.note("film", Duration::from_secs(2), false);
        assert_eq!(
            (stage.cost("film"), stage.cost("bsdf")),
            (Duration::from_secs(2), Duration::from_secs(4))
        );
    }

    #[test]
    fn silence_is_no_end() {
        let (sender, lines) = channel();
        assert_eq!(watch(&lines, Duration::ZERO, Duration::MAX), Some(End::Broken("no end")));
        assert_eq!(watch(&lines, PATIENCE, Duration::ZERO), Some(End::Unfinished));
        sender.send("test a ... FAILED".into()).unwrap();
        assert_eq!(watch(&lines, PATIENCE, Duration::MAX), Some(End::Failed("a".into())));
        drop(sender);
        assert_eq!(watch(&lines, PATIENCE, Duration::MAX), None);
    }
}
