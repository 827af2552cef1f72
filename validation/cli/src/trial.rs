//! Trials: a subject, a check and a direction under a name.

use crate::console::say;
use crate::direction::Direction;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use validation::checks::{CHECKS, Check, Effort};
use validation::statistics::{Verdict, seed_for};
use validation::{Outcome, Scatterer};

/// Creates the subject for each trial, so that trials can run in parallel.
pub type Source = Arc<dyn Fn() -> Result<Box<dyn Scatterer>, String> + Send + Sync>;

/// A check of a subject for one direction.
#[derive(Clone)]
pub struct Trial {
    pub name: String,
    source: Source,
    check: &'static Check,
    from: Direction,
}

/// The trials of a subject with every check except those that `without` names, from several directions.
pub fn trials_of(name: &str, source: &Source, directions: &[Direction], without: &[&str]) -> Vec<Trial> {
    let checks = CHECKS.iter().filter(|check| !without.contains(&check.name));
    let pairs = checks.flat_map(|check| directions.iter().map(move |&from| (check, from)));
    let trial = |(check, from): (&'static Check, Direction)| Trial {
        name: format!("{name}::{}::{from}", check.name),
        source: source.clone(),
        check,
        from,
    };
    pairs.map(trial).collect()
}

impl Trial {
    /// The name of its check.
    pub fn check(&self) -> &'static str {
        self.check.name
    }

    /// Runs the check once for each of these numbers; computations that do not depend on the seed are shared.
    /// Empty if the check does not apply to the subject.
    pub fn repeat(&self, effort: &Effort, numbers: Range<u64>) -> Result<Vec<Outcome>, String> {
        let subject = (self.source)()?;
        if !(self.check.applies)(subject.as_ref()) {
            return Ok(vec![]);
        }
        let seed = |number: u64| seed_for(&self.name, number);
        let outcomes = match self.from {
            Direction::At(_) => {
                let seeds: Vec<u64> = numbers.map(seed).collect();
                self.check.repeat(subject.as_ref(), self.from.vector(&self.name, 0), &seeds, effort)
            }
            Direction::Drawn => {
                let ask = |number: u64| {
                    let wo = self.from.vector(&self.name, number);
                    self.check.run(subject.as_ref(), wo, seed(number), effort)
                };
                numbers.map(ask).collect()
            }
        };
        Ok(outcomes.into_iter().map(|outcome| outcome.of(&self.name)).collect())
    }

    /// Runs the check; `None` if it does not apply to the subject. `number` determines the seed, and the direction if it
    /// is drawn.
    pub fn run(&self, effort: &Effort, number: u64) -> Result<Option<Outcome>, String> {
        let subject = (self.source)()?;
        if !(self.check.applies)(subject.as_ref()) {
            return Ok(None);
        }
        let wo = self.from.vector(&self.name, number);
        let outcome = self.check.run(subject.as_ref(), wo, seed_for(&self.name, number), effort);
        Ok(Some(outcome.of(&self.name)))
    }
}

/// The effort of a suite of `count` trials, which share a level of 1 % (Šidák).
pub fn effort(samples: usize, count: usize, thorough: bool) -> Effort {
    let level = validation::statistics::sidak(0.01, count);
    // Values are f32: they lose digits below 1e-38, and products of grazing cosines are small.
    Effort { samples, level, smallest: 1e-30, thorough, ..Effort::default() }
}

/// The effort of a suite with points in filters, whose polynomials reach zero by cancellation.
pub fn effort_of_sampling(samples: usize, count: usize, thorough: bool) -> Effort {
    Effort { smallest: 1e-9, ..effort(samples, count, thorough) }
}

/// Counts inconclusive outcomes of a test suite. Tests take few samples, and an inconclusive one must not
/// fail; but if many are, the suite is inconclusive as a whole.
#[derive(Default)]
pub struct Tally {
    asked: AtomicUsize,
    undecided: AtomicUsize,
}

impl Tally {
    /// Converts an outcome for libtest-mimic: only a fault fails.
    pub fn judge(&self, outcome: Option<Outcome>) -> Result<(), String> {
        let Some(outcome) = outcome else { return Ok(()) };
        self.asked.fetch_add(1, Ordering::Relaxed);
        match outcome.verdict {
            Verdict::Different => return Err(outcome.message),
            Verdict::Inconclusive => {
                self.undecided.fetch_add(1, Ordering::Relaxed);
            }
            Verdict::Equivalent => {}
        }
        Ok(())
    }

    /// Ends the program with a failure if there are at least a hundred outcomes, of which a larger share than
    /// `most` is inconclusive.
    pub fn exit_if_undecided(&self, most: f64) {
        let [asked, undecided] = [&self.asked, &self.undecided].map(|count| count.load(Ordering::Relaxed));
        if asked > 0 {
            say(format_args!("{undecided} of {asked} answers are undecided"));
        }
        if asked >= 100 && undecided as f64 > most * asked as f64 {
            eprintln!("error: more than {:.1} % are", 100.0 * most);
            std::process::exit(1);
        }
    }
}
