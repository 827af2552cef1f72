//! The ledger: results of reseeded runs of the suite, one JSON object per line, and tests of whether they
//! agree with chance. P-values must be uniform, and a suite at level 1 % must reject a correct renderer in
//! one of a hundred runs.

pub mod command;

use crate::crew::ask_all;
use crate::files;
use crate::provenance::Provenance;
use crate::trial::Trial;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use validation::checks::Effort;
use validation::report::{Outcome, Report};
use validation::statistics::binomial::binomial_two_sided;
use validation::statistics::{Verdict, uniformity};

/// Level at which the p-values of one check are called not uniform.
const LEVEL: f64 = 0.001;

/// The level that all trials of a run share.
const SUITE: f64 = 0.01;

/// Bars of the histogram in the summary.
const BARS: usize = 20;

/// A line of the file.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum Line {
    PValue {
        check: String,
        subject: String,
        number: u64,
        #[serde(deserialize_with = "probability")]
        p: f64,
    },
    /// A run of the suite.
    Run {
        run: u64,
        /// How many there were; 0 if the run was not of the whole suite.
        trials: usize,
        samples: usize,
        /// The outcomes that were called different, with the reason.
        rejected: Vec<String>,
    },
}

fn probability<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let p = f64::deserialize(from)?;
    if (0.0..=1.0).contains(&p) { Ok(p) } else { Err(D::Error::custom("expected 0 to 1")) }
}

/// Summary of a ledger, as a document to be committed.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    #[serde(flatten)]
    made: Provenance,
    /// Number of runs by their samples per trial.
    samples: BTreeMap<usize, usize>,
    p_values: usize,
    /// Share of all p-values in each twentieth of \[0, 1\].
    histogram: Vec<f64>,
    runs: usize,
    /// Number of runs in which some trial rejected.
    rejecting_runs: usize,
    /// Messages of the trials that rejected.
    rejected: Vec<String>,
    report: Report,
}

/// Appends the p-values of `outcomes` to a file.
pub fn append(path: &Path, outcomes: &[Outcome], number: u64) -> Result<(), String> {
    write(path, outcomes.iter().filter_map(|outcome| p_value(outcome, number)))
}

/// Runs all trials once for each of `numbers`, and appends the p-values and the rejections. A run of some
/// trials alone says nothing of how often the `whole` suite rejects, and counts as one of none.
pub fn rerun(
    path: &Path,
    trials: &[(Trial, Effort)],
    whole: bool,
    numbers: Range<u64>,
) -> Result<(), String> {
    let mut runs: BTreeMap<u64, Vec<String>> = numbers.clone().map(|number| (number, vec![])).collect();
    let mut lines = vec![];
    for outcomes in ask_all(trials, |(trial, effort)| trial.repeat(effort, numbers.clone()))? {
        for (number, outcome) in numbers.clone().zip(outcomes?) {
            lines.extend(p_value(&outcome, number));
            if outcome.verdict == Verdict::Different {
                let what = format!("{}: {}", outcome.subject, outcome.message);
                runs.entry(number).or_default().push(what);
            }
        }
    }
    let samples = trials.first().map_or(0, |(_, effort)| effort.samples);
    let counted = if whole { trials.len() } else { 0 };
    let run = |(run, rejected)| Line::Run { run, trials: counted, samples, rejected };
    write(path, lines.into_iter().chain(runs.into_iter().map(run)))
}

/// The number after those of the runs in a file.
pub fn next(path: &Path) -> Result<u64, String> {
    let lines = if path.exists() { read(path)? } else { vec![] };
    let runs =
        lines.iter().filter_map(|line| if let Line::Run { run, .. } = line { Some(*run) } else { None });
    Ok(runs.max().map_or(0, |last| last + 1))
}

fn p_value(outcome: &Outcome, number: u64) -> Option<Line> {
    let (check, subject) = (outcome.check.clone(), outcome.subject.clone());
    // JSON has no NaN; a test that gives one counts as rejected.
    outcome.p_value.map(|p| Line::PValue { check, subject, number, p: if p.is_nan() { 0.0 } else { p } })
}

fn write(path: &Path, lines: impl Iterator<Item = Line>) -> Result<(), String> {
    let lines: Result<Vec<String>, _> = lines.map(|line| serde_json::to_string(&line)).collect();
    let lines = lines.map_err(|e| format!("{}: {e}", path.display()))?;
    if lines.is_empty() { Ok(()) } else { files::append(path, &lines.join("\n")) }
}

fn read(path: &Path) -> Result<Vec<Line>, String> {
    files::lines(path, "a p-value or a run")
}

/// Least number of p-values or runs for a verdict.
const ENOUGH: usize = 200;

/// Tests each check's p-values, and all together, for uniformity (Kolmogorov and Smirnov), and the runs for
/// their level.
pub fn judge(path: &Path) -> Result<Summary, String> {
    let mut checks: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut samples: BTreeMap<usize, usize> = BTreeMap::new();
    let (mut runs, mut rejecting_runs, mut complaints) = (0, 0, vec![]);
    let (mut known, mut known_runs) = (BTreeSet::new(), BTreeSet::new());
    for line in read(path)? {
        match line {
            Line::PValue { check, subject, number, p } => {
                // The same test with the same seed is one piece of evidence, however often it was run.
                if known.insert((check.clone(), subject, number)) {
                    for name in [check, "all".to_string()] {
                        checks.entry(name).or_default().push(p);
                    }
                }
            }
            Line::Run { trials: 0, .. } => {}
            // And so is a run.
            Line::Run { run, .. } if !known_runs.insert(run) => {}
            Line::Run { rejected, samples: each, .. } => {
                runs += 1;
                *samples.entry(each).or_default() += 1;
                rejecting_runs += usize::from(!rejected.is_empty());
                complaints.extend(rejected);
            }
        }
    }
    let all = checks.get("all").cloned().unwrap_or_default();
    let mut outcomes: Vec<Outcome> = checks.into_iter().map(uniform).collect();
    if runs > 0 {
        outcomes.push(level(runs, rejecting_runs));
    }
    let bar = |i: usize| {
        let inside = |p: &&f64| ((**p * BARS as f64) as usize).min(BARS - 1) == i;
        all.iter().filter(inside).count() as f64 / all.len().max(1) as f64
    };
    Ok(Summary {
        made: Provenance::here(),
        samples,
        p_values: all.len(),
        histogram: (0..BARS).map(bar).collect(),
        runs,
        rejecting_runs,
        rejected: complaints,
        report: Report::new("ledger", outcomes),
    })
}

impl Summary {
    /// The outcomes of the tests.
    pub fn report(&self) -> &Report {
        &self.report
    }
}

fn uniform((check, values): (String, Vec<f64>)) -> Outcome {
    let uniform = uniformity(&values);
    let verdict = match uniform > LEVEL {
        false => Verdict::Different,
        true if values.len() < ENOUGH => Verdict::Inconclusive,
        true => Verdict::Equivalent,
    };
    let share = |limit: f64| values.iter().filter(|p| **p <= limit).count() as f64 / values.len() as f64;
    let message = format!(
        "{} p-values, of which {:.4} ≤ 0.01 and {:.4} ≤ 0.001; uniform: p = {uniform:.4}",
        values.len(),
        share(0.01),
        share(0.001)
    );
    let outcome = Outcome::new("uniformity", verdict, message).of(check);
    outcome.p_value(uniform).figure("count", values.len() as f64)
}

/// Whether the number of rejecting runs agrees with the level: of 200 at 1 %, six do and seven (with
/// probability 1/230) do not.
fn level(runs: usize, rejecting: usize) -> Outcome {
    let p = binomial_two_sided(rejecting as u64, runs as u64, SUITE);
    let excessive = rejecting as f64 > SUITE * runs as f64 && p < 0.01;
    let verdict = match excessive {
        true => Verdict::Different,
        false if runs < ENOUGH => Verdict::Inconclusive,
        false => Verdict::Equivalent,
    };
    let message = format!("{rejecting} of {runs} runs reject at level {SUITE}");
    Outcome::new("level", verdict, message).of("suite").figure("runs", runs as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::statistics::Stream;

    #[test]
    fn a_ledger_of_uniform_values_holds_and_a_bent_one_does_not() {
        let path = std::env::temp_dir().join(format!("ledger-{}.jsonl", std::process::id()));
        for (power, verdict) in [(1.0, Verdict::Equivalent), (1.1, Verdict::Different)] {
            let mut stream = Stream::named("ledger", 0);
            let p_values = (0..10_000).map(|_| libm::pow(stream.uniform(), power));
            let outcome =
                |(i, p)| Outcome::new("chi2", Verdict::Equivalent, "").of(format!("subject {i}")).p_value(p);
            let outcomes: Vec<Outcome> = p_values.enumerate().map(outcome).collect();
            append(&path, &outcomes, 3).unwrap();
            assert_eq!(judge(&path).unwrap().report.verdict, verdict);
            // Appended again, they are the same evidence.
            append(&path, &outcomes, 3).unwrap();
            assert_eq!(judge(&path).unwrap().p_values, 10_000);
            std::fs::remove_file(&path).unwrap();
        }
    }

    #[test]
    fn six_of_two_hundred_runs_may_reject_and_seven_may_not() {
        assert_eq!(level(200, 6).verdict, Verdict::Equivalent);
        assert_eq!(level(200, 7).verdict, Verdict::Different);
        assert_eq!(level(200, 0).verdict, Verdict::Equivalent);
        assert_eq!([level(1, 0).verdict, level(199, 1).verdict], [Verdict::Inconclusive; 2]);
    }

    #[test]
    fn runs_are_counted_on() {
        let path = std::env::temp_dir().join(format!("runs-{}.jsonl", std::process::id()));
        assert_eq!(next(&path).unwrap(), 0);
        let run = |run, rejected| Line::Run { run, trials: 2, samples: 16, rejected };
        write(&path, [run(0, vec![]), run(1, vec!["x".into()])].into_iter()).unwrap();
        let summary = judge(&path).unwrap();
        assert_eq!((summary.runs, summary.rejecting_runs, next(&path).unwrap()), (2, 1, 2));
        write(&path, [run(1, vec!["x".into()])].into_iter()).unwrap();
        assert_eq!(judge(&path).unwrap().runs, 2);
        // A run of a part of the suite has a number, and says nothing of the suite.
        let part = Line::Run { run: 2, trials: 0, samples: 16, rejected: vec!["x".into()] };
        write(&path, [part].into_iter()).unwrap();
        let summary = judge(&path).unwrap();
        assert_eq!((summary.runs, summary.rejecting_runs, next(&path).unwrap()), (2, 1, 3));
        // What an interruption has torn is passed over, and what is no line of a ledger is not.
        std::fs::write(&path, files::text(&path).unwrap() + r#"{"run": 7, "tri"#).unwrap();
        write(&path, [run(3, vec![])].into_iter()).unwrap();
        assert_eq!((judge(&path).unwrap().runs, next(&path).unwrap()), (3, 4));
        for wrong in ["{}", r#"{"check":"a","subject":"b","number":0,"p":1.5}"#] {
            std::fs::write(&path, wrong.to_owned() + "\n").unwrap();
            assert!(judge(&path).is_err_and(|error| error.contains(":1: expected a p-value or a run")));
        }
        std::fs::remove_file(&path).unwrap();
    }
}
