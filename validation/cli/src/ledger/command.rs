//! The command line of `validate ledger`.

use super::{judge, next, rerun};
use crate::console::{all_known, check_writable, print, say, write};
use crate::trial::{Trial, effort, effort_of_sampling};
use crate::{limits, materials, sampling};
use std::collections::BTreeSet;
use std::error::Error;
use std::path::PathBuf;
use validation::Verdict;
use validation::checks::Effort;
use validation::report::to_json;

/// Whether the p-values of a ledger are uniform, and its reseeded runs reject as often as their level says.
#[derive(clap::Args)]
pub struct Arguments {
    file: PathBuf,
    /// First run the whole suite so many times more, with seeds that the file has not had
    #[arg(long, value_name = "RUNS", default_value_t = 0)]
    reseed: u64,
    /// Runs that share their integrals; the file grows after as many
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    batch: u64,
    /// Samples a check of these runs
    #[arg(long, default_value_t = 1 << 12, value_parser = crate::console::samples)]
    samples: usize,
    /// Only these checks are run
    #[arg(long = "check", value_name = "NAME", requires = "reseed")]
    checks: Vec<String>,
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the reseeded suites, and judges the whole file.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn Error>> {
    let Arguments { file, reseed, batch, samples, checks, json } = arguments;
    check_writable(&[&file], &[&json])?;
    let mut suite = suite(samples);
    let known: BTreeSet<&str> = suite.iter().map(|(trial, _)| trial.check()).collect();
    all_known("check", &checks, known.into_iter())?;
    suite.retain(|(trial, _)| checks.is_empty() || checks.iter().any(|check| check == trial.check()));
    let first = if reseed == 0 { 0 } else { next(&file)? };
    let mut done = 0;
    while done < reseed {
        let more = batch.min(reseed - done);
        rerun(&file, &suite, checks.is_empty(), first + done..first + done + more)?;
        done += more;
        say(format_args!("{done} of {reseed} runs"));
    }
    let summary = judge(&file)?;
    if summary.report().outcomes.is_empty() {
        say(format_args!("the file holds neither p-values nor runs"));
    }
    summary.report().outcomes.iter().for_each(print);
    write(json.as_deref(), || Ok(to_json(&summary)?))?;
    Ok(summary.report().verdict)
}

/// All trials of materials and of other sampled distributions with their efforts; together they share a level
/// of 1 %.
fn suite(samples: usize) -> Vec<(Trial, Effort)> {
    let scattered = [materials::trials(None), limits::trials(None)].concat();
    let drawn = sampling::trials(None);
    let count = scattered.len() + drawn.len();
    let [one, other] = [effort(samples, count, false), effort_of_sampling(samples, count, false)];
    let with = |effort: Effort| move |trial| (trial, effort);
    scattered.into_iter().map(with(one)).chain(drawn.into_iter().map(with(other))).collect()
}
