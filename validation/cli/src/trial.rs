//! A subject, a check and a direction: one named test.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use validation::checks::{CHECKS, Check, Effort};
use validation::scatterer::{DVec3, direction};
use validation::statistics::{Verdict, seed_for};
use validation::{Outcome, Scatterer};

/// Angles of incidence in degrees; over 90 is from below.
pub const ANGLES: [f64; 5] = [0.0, 35.0, 75.0, 89.0, 150.0];

/// Makes the subject anew for each trial, so that trials can run at once.
pub type Source = Arc<dyn Fn() -> Result<Box<dyn Scatterer>, String> + Send + Sync>;

/// One thing to be checked.
#[derive(Clone)]
pub struct Trial {
    pub name: String,
    source: Source,
    check: &'static Check,
    wo: DVec3,
}

/// A subject under every check but those that `without` names, from several angles.
pub fn trials_of(name: &str, source: &Source, angles: &[f64], without: &[&str]) -> Vec<Trial> {
    let checks = CHECKS.iter().filter(|check| !without.contains(&check.name));
    let pairs = checks.flat_map(|check| angles.iter().map(move |&angle| (check, angle)));
    let trial = |(check, angle): (&'static Check, f64)| Trial {
        name: format!("{name}::{}::{angle}", check.name),
        source: source.clone(),
        check,
        wo: from(angle),
    };
    pairs.map(trial).collect()
}

/// The direction at an angle in degrees from the normal, off all axes.
pub fn from(degrees: f64) -> DVec3 {
    direction(etalon::math::function::cos(degrees.to_radians()), 0.7)
}

impl Trial {
    /// The name of its check.
    pub fn check(&self) -> &'static str {
        self.check.name
    }

    /// Runs the check once for each of these numbers, which share what no seed decides; nothing if the check
    /// has nothing to say about the subject.
    pub fn repeat(&self, effort: &Effort, numbers: Range<u64>) -> Result<Vec<Outcome>, String> {
        let subject = (self.source)()?;
        if !(self.check.applies)(subject.as_ref()) {
            return Ok(vec![]);
        }
        let seeds: Vec<u64> = numbers.map(|number| seed_for(&self.name, number)).collect();
        let outcomes = self.check.repeat(subject.as_ref(), self.wo, &seeds, effort);
        Ok(outcomes.into_iter().map(|outcome| outcome.of(&self.name)).collect())
    }

    /// Runs the check; `None` if it has nothing to say about the subject. `number` draws another seed.
    pub fn run(&self, effort: &Effort, number: u64) -> Result<Option<Outcome>, String> {
        let subject = (self.source)()?;
        if !(self.check.applies)(subject.as_ref()) {
            return Ok(None);
        }
        let outcome = self.check.run(subject.as_ref(), self.wo, seed_for(&self.name, number), effort);
        Ok(Some(outcome.of(&self.name)))
    }
}

/// How hard to look: `count` trials share a level of 1 % (Šidák).
pub fn effort(samples: usize, count: usize, thorough: bool) -> Effort {
    let level = validation::statistics::sidak(0.01, count);
    // Values are f32: digits end at 1e-38, and cosines of grazing angles multiply.
    Effort { samples, level, smallest: 1e-30, thorough, ..Effort::default() }
}

/// The same for places in filters, whose polynomials reach zero by cancellation.
pub fn effort_of_sampling(samples: usize, count: usize, thorough: bool) -> Effort {
    Effort { smallest: 1e-9, ..effort(samples, count, thorough) }
}

/// How many answers of a suite of tests are none. Tests take few samples, and one that cannot tell must not
/// fail; but if many could not, the suite would say nothing.
#[derive(Default)]
pub struct Tally {
    asked: AtomicUsize,
    undecided: AtomicUsize,
}

impl Tally {
    /// The outcome as libtest-mimic sees it: only a fault fails.
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

    /// Ends the program with a failure if of a hundred answers and more a larger share than this were none.
    pub fn exit_if_undecided(&self, most: f64) {
        let [asked, undecided] = [&self.asked, &self.undecided].map(|count| count.load(Ordering::Relaxed));
        if asked > 0 {
            println!("{undecided} of {asked} answers are undecided");
        }
        if asked >= 100 && undecided as f64 > most * asked as f64 {
            eprintln!("error: more than {:.1} % are", 100.0 * most);
            std::process::exit(1);
        }
    }
}
