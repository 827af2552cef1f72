//! What is said on standard output, and how numbers are read from the command line.

use crate::provenance::Made;
use std::error::Error;
use std::fmt::Arguments;
use std::io::Write;
use std::path::PathBuf;
use validation::report::to_json;
use validation::{Outcome, Report, Verdict};

/// A line on standard output. A reader that has had enough, such as `head`, is no reason to stop: documents are still
/// written, and the exit code still tells.
pub fn say(line: Arguments) {
    writeln!(std::io::stdout(), "{line}").ok();
}

/// An outcome as a line.
pub fn print(outcome: &Outcome) {
    say(format_args!("{:<13} {}: {}", outcome.verdict.to_string(), outcome.subject, outcome.message));
}

/// The last line of a command, and its document where one is wanted.
pub fn finish(report: Report, json: Option<PathBuf>) -> Result<Verdict, Box<dyn Error>> {
    let count = |v: Verdict| report.outcomes.iter().filter(|o| o.verdict == v).count();
    let (equal, open, bad) =
        (count(Verdict::Equivalent), count(Verdict::Inconclusive), count(Verdict::Different));
    say(format_args!("{}: {equal} hold, {open} inconclusive, {bad} differ", report.verdict));
    if let Some(path) = json {
        std::fs::write(path, to_json(&Made::here(&report)?)? + "\n")?;
    }
    Ok(report.verdict)
}

/// A share written with a per cent sign. Error: anything else, or nothing at all.
pub fn percentage(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('%').parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
    number.map(|v| v / 100.0).ok_or_else(|| "expected such as 0.25%".into())
}
