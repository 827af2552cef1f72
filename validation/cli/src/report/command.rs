//! The command line of `validate report`.

use super::{Effort, write};
use crate::console::say;
use std::path::PathBuf;
use validation::Verdict;

#[derive(clap::Args)]
pub struct Arguments {
    #[arg(short, long, value_name = "HTML", default_value = "report.html")]
    output: PathBuf,
    /// Take what the JSON documents of this folder answer from there
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Fewer samples and directions, fewer cases and scenes
    #[arg(long)]
    quick: bool,
}

/// Writes the page.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn std::error::Error>> {
    let Arguments { output, from, quick } = arguments;
    let effort = if quick { Effort::QUICK } else { Effort::USUAL };
    let verdict = write(&output, from.as_deref(), effort, |step| eprintln!("{step}"))?;
    say(format_args!("{verdict}: {}", output.display()));
    Ok(verdict)
}
