//! The command line of the harness: `validate bsdf`, `images`, `scenes`, `museum`.

use clap::Parser;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use validate::{materials, museum, references};
use validation::image::{self, Settings};
use validation::report::to_json;
use validation::{Outcome, Report, Verdict};

/// Judges materials, images and scenes.
///
/// Exit codes: 0 holds, 1 different, 2 bad input, 3 inconclusive.
#[derive(Parser)]
#[command(version)]
enum Command {
    /// All checks on all materials, or on one
    Bsdf {
        /// Only this material
        name: Option<String>,
        /// Samples a check
        #[arg(long, default_value_t = 1 << 18)]
        samples: usize,
        /// Another number, other seeds
        #[arg(long, default_value_t = 0)]
        number: u64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Whether two images have the same expectation
    Images {
        /// The reference
        a: PathBuf,
        b: PathBuf,
        /// Largest relative difference of a channel's mean that is none, such as 0.25%
        #[arg(long, default_value = "0.25%", value_parser = percentage)]
        margin: f64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        /// Write a picture of signed z-scores
        #[arg(long, value_name = "PNG")]
        map: Option<PathBuf>,
    },
    /// Etalon against the stored references
    Scenes {
        /// Only scenes whose name contains this
        name: Option<String>,
        /// Samples a pixel
        #[arg(long, default_value_t = 1024)]
        spp: u32,
        /// Largest relative difference of a channel's mean that is none
        #[arg(long, default_value = "0.5%", value_parser = percentage)]
        margin: f64,
        /// Another number, other seeds
        #[arg(long, default_value_t = 0)]
        number: u64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Whether the tests notice bugs, those of `validation/museum` or mutants
    Museum(museum::command::Arguments),
}

fn main() -> ExitCode {
    match run(Command::parse()) {
        Ok(verdict) => ExitCode::from(verdict.exit_code()),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(command: Command) -> Result<Verdict, Box<dyn Error>> {
    match command {
        Command::Bsdf { name, samples, number, json } => {
            let trials = materials::trials(name.as_deref());
            if trials.is_empty() {
                return Err("there is no such material; see `etalon plugins`".into());
            }
            // Every trial shares the suite's level of 1 % (Šidák).
            let level = validation::statistics::sidak(0.01, trials.len());
            let mut outcomes = vec![];
            for trial in trials {
                if let Some(outcome) = trial.run(samples, level, number)? {
                    print(&outcome);
                    outcomes.push(outcome);
                }
            }
            finish(Report::new("materials", outcomes), json)
        }
        Command::Images { a, b, margin, json, map } => {
            let settings = Settings::with_margin(margin);
            let (first, second) = (image::load(&a)?, image::load(&b)?);
            let comparison = image::compare(&first, &second, &settings)?;
            if let Some(path) = map {
                image::write_difference_map(&first, &second, &settings, &path)?;
            }
            if let Some(path) = json {
                std::fs::write(path, to_json(&comparison)?)?;
            }
            println!("{}: {}", comparison.verdict, comparison.message);
            Ok(comparison.verdict)
        }
        Command::Scenes { name, spp, margin, number, json } => {
            let mut outcomes = vec![];
            for reference in references::references(&references::folder())? {
                if name.as_ref().is_none_or(|n| reference.name.contains(n)) {
                    let outcome = reference.check(spp, margin, number)?;
                    print(&outcome);
                    outcomes.push(outcome);
                }
            }
            finish(Report::new("scenes", outcomes), json)
        }
        Command::Museum(arguments) => Ok(museum::command::run(arguments)?),
    }
}

fn print(outcome: &Outcome) {
    println!("{:<13} {}: {}", outcome.verdict.to_string(), outcome.subject, outcome.message);
}

fn finish(report: Report, json: Option<PathBuf>) -> Result<Verdict, Box<dyn Error>> {
    let count = |v: Verdict| report.outcomes.iter().filter(|o| o.verdict == v).count();
    let (equal, open, bad) =
        (count(Verdict::Equivalent), count(Verdict::Inconclusive), count(Verdict::Different));
    println!("{}: {equal} hold, {open} inconclusive, {bad} differ", report.verdict);
    if let Some(path) = json {
        std::fs::write(path, to_json(&report)?)?;
    }
    Ok(report.verdict)
}

fn percentage(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('%').parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
    number.map(|v| v / 100.0).ok_or_else(|| "expected such as 0.25%".into())
}
