//! What is said on standard output, and how numbers are read from the command line.

use std::fmt::Arguments;
use std::io::Write;
use validation::Outcome;

/// A line on standard output. A reader that has had enough, such as `head`, is no reason to stop: documents are still
/// written, and the exit code still tells.
pub fn say(line: Arguments) {
    writeln!(std::io::stdout(), "{line}").ok();
}

/// An outcome as a line.
pub fn print(outcome: &Outcome) {
    say(format_args!("{:<13} {}: {}", outcome.verdict.to_string(), outcome.subject, outcome.message));
}

/// A share written with a per cent sign. Error: anything else, or nothing at all.
pub fn percentage(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('%').parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
    number.map(|v| v / 100.0).ok_or_else(|| "expected such as 0.25%".into())
}
