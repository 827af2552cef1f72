//! The process that supervises the worker, and records what it finds.

use super::seeds::Seeds;
use super::{Format, HANG};
use serde::Serialize;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// A violation of a limit by an input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Number of the input.
    pub input: u64,
    /// The panic's message, or which limit was exceeded.
    pub what: String,
}

/// Results of a run on one format.
#[derive(Debug, Serialize)]
pub struct Record {
    pub format: &'static str,
    /// Number of seed files.
    pub seeds: usize,
    /// Number of inputs read.
    pub inputs: u64,
    pub seconds: f64,
    /// The largest memory use of an input, as a share of what it is allowed.
    pub most_memory: f64,
    /// The longest time an input took.
    pub slowest_seconds: f64,
    pub findings: Vec<Finding>,
}

/// Which inputs to read, and for how long at most.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Number of the first input.
    pub first: u64,
    /// Number of inputs.
    pub count: u64,
    /// Time limit of the run.
    pub time: Duration,
}

/// Number of findings after which a run ends.
const ENOUGH: usize = 100;

/// Runs workers until the effort is spent. `start` makes the command of a worker from the number of its first
/// input, the number of inputs and a time limit.
pub fn watch(
    format: &'static Format,
    seeds: &Seeds,
    effort: Effort,
    start: impl Fn(u64, u64, Duration) -> Command,
) -> Result<Record, String> {
    let begin = Instant::now();
    let mut record = Record {
        format: format.name,
        seeds: seeds.count(),
        inputs: 0,
        seconds: 0.0,
        most_memory: 0.0,
        slowest_seconds: 0.0,
        findings: vec![],
    };
    let (mut next, end) = (effort.first, effort.first.saturating_add(effort.count));
    while next < end && begin.elapsed() < effort.time && record.findings.len() < ENOUGH {
        let mut command = start(next, end - next, effort.time.saturating_sub(begin.elapsed()));
        let child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let (last, done) = follow(child.map_err(|e| e.to_string())?, format, seeds, next, &mut record)?;
        next = last + 1;
        if done {
            break;
        }
    }
    record.inputs = next - effort.first;
    record.seconds = begin.elapsed().as_secs_f64();
    Ok(record)
}

/// Follows one worker to its end, or until there are enough findings; returns the last input it read and whether
/// it ended normally.
fn follow(
    mut child: Child,
    format: &Format,
    seeds: &Seeds,
    first: u64,
    record: &mut Record,
) -> Result<(u64, bool), String> {
    let output = child.stdout.take().ok_or("the worker has no output")?;
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    let (mut last, mut since, mut done) = (first, Instant::now(), false);
    // Whether the worker was ended, and did not end itself.
    let mut stopped = false;
    let mut broken = None;
    let find = |input: u64, what: String, findings: &mut Vec<Finding>| findings.push(Finding { input, what });
    while !stopped {
        match lines.recv_timeout(HANG) {
            Ok(line) => {
                if let Ok(number) = line.parse::<u64>() {
                    (last, since) = (number, Instant::now());
                } else if let Some(words) = line.strip_prefix("panic ") {
                    find(last, words.to_owned(), &mut record.findings);
                } else if let Some(bytes) = line.strip_prefix("memory ").and_then(|b| b.parse::<usize>().ok())
                {
                    record.slowest_seconds = record.slowest_seconds.max(since.elapsed().as_secs_f64());
                    let (base, times) = format.memory;
                    let allowed = base + times * seeds.input(format, last).len();
                    let share = bytes as f64 / allowed as f64;
                    record.most_memory = record.most_memory.max(share);
                    if share > 1.0 {
                        find(last, format!("{bytes} bytes, and {allowed} are allowed"), &mut record.findings);
                    }
                } else if let Some(words) = line.strip_prefix("broken ") {
                    broken = Some(words.to_owned());
                } else if line == "done" {
                    done = true;
                }
                stopped = record.findings.len() >= ENOUGH || broken.is_some();
            }
            Err(RecvTimeoutError::Timeout) => {
                find(last, format!("no end within {} s", HANG.as_secs()), &mut record.findings);
                stopped = true;
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    if stopped {
        child.kill().map_err(|e| e.to_string())?;
    }
    let status = child.wait().map_err(|e| e.to_string())?;
    if let Some(words) = broken {
        return Err(words);
    }
    if !done && !stopped {
        find(last, format!("the process died: {status}"), &mut record.findings);
    }
    Ok((last, done))
}

/// Writes the inputs of findings to a folder.
pub fn save(format: &Format, seeds: &Seeds, record: &Record, folder: &Path) -> Result<(), String> {
    for finding in &record.findings {
        let file = folder.join(format!("{}-{}.{}", format.name, finding.input, format.extensions[0]));
        let bytes = seeds.input(format, finding.input);
        std::fs::write(&file, bytes).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    Ok(())
}
