//! The documents that a command writes of its outcomes: all of them, or a digest short enough to be
//! committed.

use crate::console::{check_writable, say, write};
use crate::provenance::Made;
use serde::Serialize;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use validation::report::to_json;
use validation::{Outcome, Report, Verdict};

/// The documents to write.
#[derive(clap::Args)]
pub struct Documents {
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a short one: counts and figures by check, and what does not hold
    #[arg(long, value_name = "FILE")]
    digest: Option<PathBuf>,
}

impl Documents {
    /// Tests in advance whether the documents and `others` can be written, none of them over what is read.
    pub fn check_writable(&self, read: &[&Path], others: &[&Option<PathBuf>]) -> Result<(), Box<dyn Error>> {
        check_writable(read, &[&[&self.json, &self.digest], others].concat())
    }

    /// Prints the number of outcomes that hold, as the last line of a command, and writes the documents.
    pub fn finish(self, report: Report) -> Result<Verdict, Box<dyn Error>> {
        let Tally { hold, inconclusive, differ, .. } = Tally::of(report.outcomes.iter());
        say(format_args!("{}: {hold} hold, {inconclusive} inconclusive, {differ} differ", report.verdict));
        write(self.json.as_deref(), || Ok(to_json(&Made::here(&report))?))?;
        write(self.digest.as_deref(), || Ok(to_json(&Made::here(&Digest::of(&report)))?))?;
        Ok(report.verdict)
    }
}

/// A report without the outcomes that hold.
#[derive(Debug, Serialize)]
struct Digest<'a> {
    title: &'a str,
    verdict: Verdict,
    checks: BTreeMap<&'a str, Tally<'a>>,
    /// Subject and message of each outcome that was not shown to hold.
    open: Vec<[&'a str; 2]>,
}

/// The counts of one check over all subjects.
#[derive(Debug, Default, Serialize)]
struct Tally<'a> {
    hold: usize,
    inconclusive: usize,
    differ: usize,
    /// Minimum and maximum of each figure over the outcomes that hold.
    figures: BTreeMap<&'a str, [f64; 2]>,
}

impl<'a> Digest<'a> {
    fn of(report: &'a Report) -> Self {
        let mut checks: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
        for outcome in &report.outcomes {
            checks.entry(&outcome.check).or_default().push(outcome);
        }
        let open = report.outcomes.iter().filter(|outcome| outcome.verdict != Verdict::Equivalent);
        Self {
            title: &report.title,
            verdict: report.verdict,
            checks: checks.into_iter().map(|(check, found)| (check, Tally::of(found.into_iter()))).collect(),
            open: open.map(|outcome| [outcome.subject.as_str(), outcome.message.as_str()]).collect(),
        }
    }
}

impl<'a> Tally<'a> {
    fn of(outcomes: impl Iterator<Item = &'a Outcome>) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            match outcome.verdict {
                Verdict::Equivalent => tally.hold += 1,
                Verdict::Inconclusive => tally.inconclusive += 1,
                Verdict::Different => tally.differ += 1,
            }
            if outcome.verdict == Verdict::Equivalent {
                for (name, &value) in &outcome.figures {
                    let range = tally.figures.entry(name).or_insert([value; 2]);
                    *range = [range[0].min(value), range[1].max(value)];
                }
            }
        }
        tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_counts_all_and_names_what_does_not_hold() {
        let outcome =
            |verdict, worst| Outcome::new("weight", verdict, "why").of("glass").figure("worst", worst);
        let found = [
            outcome(Verdict::Equivalent, 1.0),
            outcome(Verdict::Equivalent, 3.0),
            outcome(Verdict::Inconclusive, 7.0),
            outcome(Verdict::Different, 9.0),
        ];
        let report = Report::new("materials", found.to_vec());
        let digest = Digest::of(&report);
        let tally = &digest.checks["weight"];
        assert_eq!((tally.hold, tally.inconclusive, tally.differ), (2, 1, 1));
        assert_eq!(tally.figures["worst"], [1.0, 3.0]);
        assert_eq!(digest.open, [["glass", "why"]; 2]);
    }
}
