//! Stiff and extreme scenes, in which nothing may fail and no light may be lost.
//!
//! A case is data: a stated expectation, how it is measured, and, where `f32` or a documented design prevents
//! it, the known limit. A case with an analytic solution is a [`ClosedForm`], one with an equal scene a
//! [`Relation`]; two more measures are specific to this battery: renders of two scenes *with the same random
//! numbers*, whose pixels must then be equal except for rounding, and the worst error of a computation
//! without a picture.
//!
//! *How to add one*: an entry in the `cases` of the file it belongs to; for a new family, a file and its line
//! in [`FAMILIES`].

mod accumulation;
mod cameras;
pub mod command;
mod fresnel;
mod light;
mod optics;
mod scale_and_place;
mod self_hits;
mod spectra;
mod surfaces;
mod table;

use crate::closed_forms::ClosedForm;
use crate::metamorphic::{Relation, Term};
use crate::stage::{Family, TWICE, asked_again, confirmed, gather};
use serde::Serialize;
use std::fmt;
pub use table::updated;
use validation::statistics::{seed_for, worst_of};
use validation::{Outcome, Verdict};

/// All families, by name.
pub const FAMILIES: &[Family<Case>] = &[
    ("scale_and_place", scale_and_place::cases),
    ("surfaces", surfaces::cases),
    ("self_hits", self_hits::cases),
    ("fresnel", fresnel::cases),
    ("optics", optics::cases),
    ("cameras", cameras::cases),
    ("light", light::cases),
    ("spectra", spectra::cases),
    ("accumulation", accumulation::cases),
];

/// Factor on the samples with `--thorough`.
pub const THOROUGH: u64 = 10;

/// A computation that returns its worst error, with its effort as argument.
pub type Worst = Box<dyn Fn(u64) -> Result<f64, String> + Send + Sync>;

/// How an expectation is measured.
pub enum Measure {
    /// Against a formula; the 99 % interval of measured over expected lies within the margin.
    Answer(Box<ClosedForm>),
    /// Against another render, bit for bit or in expectation.
    Alike(Box<Relation>),
    /// Against another render with the same random numbers: Σ|a − b| over the pixels is at most this share of
    /// Σa.
    Same(Box<[Term; 2]>, f64),
    /// Against this bound on the worst error.
    AtMost(Worst, f64),
}

/// A known reason for missing an expectation, with the largest error that it explains.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    pub why: &'static str,
    pub within: f64,
}

/// A stated expectation with its measure and its known limit.
pub struct Case {
    pub name: String,
    pub expectation: String,
    pub measure: Measure,
    pub limit: Option<Limit>,
}

/// The result of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Standing {
    Holds,
    /// Missed, within a known limit.
    Limit,
    Inconclusive,
    Differs,
}

/// The results of a case, for a table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub case: String,
    pub expectation: String,
    /// The measured error; NaN if there is none, as for a comparison of bits.
    pub error: f64,
    /// The largest error that counts as holding.
    pub margin: f64,
    pub found: String,
    pub verdict: Standing,
    /// The reason for missing the expectation, if it was missed within a known limit.
    pub limit: Option<&'static str>,
}

/// All cases, named `family::case`.
pub fn cases() -> Vec<Case> {
    gather(FAMILIES, |case| &mut case.name)
}

impl Case {
    /// A case with an analytic solution, whose source is the expectation.
    pub fn answer(case: ClosedForm) -> Self {
        let (name, expectation) = (case.name.clone(), case.source.to_string());
        Self { name, expectation, measure: Measure::Answer(Box::new(case)), limit: None }
    }

    pub fn alike(expectation: &str, relation: Relation) -> Self {
        let name = relation.name.clone();
        let measure = Measure::Alike(Box::new(relation));
        Self { name, expectation: expectation.into(), measure, limit: None }
    }

    pub fn same(name: impl Into<String>, expectation: &str, scenes: [String; 2], within: f64) -> Self {
        let measure = Measure::Same(Box::new(scenes.map(Term::new)), within);
        Self { name: name.into(), expectation: expectation.into(), measure, limit: None }
    }

    pub fn at_most(
        name: impl Into<String>,
        expectation: impl Into<String>,
        within: f64,
        worst: Worst,
    ) -> Self {
        let measure = Measure::AtMost(worst, within);
        Self { name: name.into(), expectation: expectation.into(), measure, limit: None }
    }

    pub fn limit(self, why: &'static str, within: f64) -> Self {
        Self { limit: Some(Limit { why, within }), ..self }
    }

    /// Measures with `effort` times the samples; `number` determines the seeds. A case that cannot be
    /// rendered differs.
    pub fn check(&self, effort: u64, number: u64) -> Row {
        let measured = self.measure(effort, number);
        let (error, margin, found, verdict) =
            measured.unwrap_or_else(|error| (f64::NAN, f64::NAN, error, Verdict::Different));
        let verdict = match (verdict, self.limit) {
            (Verdict::Equivalent, _) => Standing::Holds,
            (_, Some(limit)) if error <= limit.within => Standing::Limit,
            (Verdict::Inconclusive, _) => Standing::Inconclusive,
            (Verdict::Different, _) => Standing::Differs,
        };
        let limit = self.limit.filter(|_| verdict == Standing::Limit).map(|limit| limit.why);
        let (case, expectation) = (self.name.clone(), self.expectation.clone());
        Row { case, expectation, error, margin, found, verdict, limit }
    }

    /// The error, the margin, a message, and whether the error is within the margin.
    fn measure(&self, effort: u64, number: u64) -> Result<(f64, f64, String, Verdict), String> {
        Ok(match &self.measure {
            Measure::Answer(case) => {
                let outcome = asked_again(number, |number| case.check(effort, number))?;
                (ratio_error(&outcome), case.margin, outcome.message, outcome.verdict)
            }
            Measure::Alike(relation) => {
                let outcome = asked_again(number, |number| relation.check(effort, number))?;
                (ratio_error(&outcome), relation.alike.margin(), outcome.message, outcome.verdict)
            }
            Measure::Same(terms, within) => {
                let error = distance(terms, 32 * effort, seed_for(&self.name, number) as u32)?;
                (error, *within, format!("mean |a − b| {error:.2e} of the mean"), judge(error, *within))
            }
            Measure::AtMost(worst, within) => {
                let error = worst(effort)?;
                (error, *within, format!("worst error {error:.2e}"), judge(error, *within))
            }
        })
    }

    /// The extreme one of the rendered scenes; `None` for a case without a picture.
    pub fn scene(&self) -> Option<Term> {
        match &self.measure {
            Measure::Answer(case) => Some(Term { mode: case.mode, ..Term::new(case.scene.clone()) }),
            Measure::Alike(relation) => relation.right.last().cloned(),
            Measure::Same(terms, _) => terms.last().cloned(),
            Measure::AtMost(..) => None,
        }
    }

    /// The case as a test: it fails if four times the samples with other seeds confirm an inconclusive or
    /// different verdict.
    pub fn test(&self) -> Result<(), String> {
        let fault = |row: Row| {
            let holds = matches!(row.verdict, Standing::Holds | Standing::Limit);
            (!holds).then(|| format!("{}: {}", row.verdict, row.found))
        };
        confirmed(&TWICE, |effort, number| Ok(fault(self.check(effort, number))))
            .map_err(|message| format!("{message}; {}", self.expectation))
    }
}

impl Row {
    /// The outcome for a report, with the result and the expectation in its message. A known limit is no
    /// difference, but is mentioned.
    pub fn outcome(&self) -> Outcome {
        let verdict = match self.verdict {
            Standing::Holds | Standing::Limit => Verdict::Equivalent,
            Standing::Inconclusive => Verdict::Inconclusive,
            Standing::Differs => Verdict::Different,
        };
        let limit = self.limit.map(|why| format!(" Known limit: {why}.")).unwrap_or_default();
        let message = format!("{}. Expected: {}.{limit}", self.found, self.expectation);
        Outcome::new("stability", verdict, message).of(&self.case)
    }
}

/// The verdict on all rows; known limits are no difference.
pub fn verdict(rows: &[Row]) -> Verdict {
    let any = |verdict: Standing| rows.iter().any(|row| row.verdict == verdict);
    if any(Standing::Differs) {
        Verdict::Different
    } else if any(Standing::Inconclusive) {
        Verdict::Inconclusive
    } else {
        Verdict::Equivalent
    }
}

fn judge(error: f64, within: f64) -> Verdict {
    // NaN does not pass.
    if error <= within { Verdict::Equivalent } else { Verdict::Different }
}

/// The largest deviation from 1 of the ratios of means in an outcome; NaN if it has none.
fn ratio_error(outcome: &Outcome) -> f64 {
    let ratios = outcome
        .figures
        .iter()
        // The ends of an interval are no ratios of their own.
        .filter(|(name, _)| *name == "ratio" || name.starts_with("ratio."))
        .filter(|(name, _)| !["ratio.low", "ratio.high"].contains(&name.as_str()));
    ratios.map(|(_, ratio)| (ratio - 1.0).abs()).reduce(worst_of).unwrap_or(f64::NAN)
}

/// Σ|a − b|/Σa over all pixels and channels of two renders with the same random numbers.
fn distance(terms: &[Term; 2], samples: u64, seed: u32) -> Result<f64, String> {
    let [a, b] = [terms[0].image(samples, seed)?, terms[1].image(samples, seed)?];
    let pairs = || a.channels.iter().zip(&b.channels).flat_map(|(a, b)| a.mean.iter().zip(&b.mean));
    Ok(pairs().map(|(a, b)| (a - b).abs()).sum::<f64>() / pairs().map(|(a, _)| a.abs()).sum::<f64>())
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Holds => "holds",
            Self::Limit => "limit",
            Self::Inconclusive => "inconclusive",
            Self::Differs => "differs",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metamorphic::still_life::{lamp, with_light};

    #[test]
    fn names_are_unique_and_expectations_stated() {
        let cases = cases();
        assert!(cases.iter().all(|case| !case.expectation.is_empty()));
        let mut names: Vec<String> = cases.into_iter().map(|case| case.name).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert!(names.len() == count && count >= 60, "{count}");
    }

    #[test]
    fn a_limit_excuses_no_more_than_it_says_and_nan_is_nothing() {
        let case = |worst: f64| Case::at_most("x", "", 1.0, Box::new(move |_| Ok(worst))).limit("", 2.0);
        let verdict = |worst: f64| case(worst).check(1, 0).verdict;
        assert_eq!(
            [0.5, 1.5, 2.5, f64::NAN].map(verdict),
            [Standing::Holds, Standing::Limit, Standing::Differs, Standing::Differs]
        );
    }

    #[test]
    fn a_limit_is_told_and_no_difference() {
        let case = |worst: f64| {
            Case::at_most("x", "nothing", 1.0, Box::new(move |_| Ok(worst))).limit("rounding", 2.0)
        };
        let outcome = |worst: f64| case(worst).check(1, 0).outcome();
        assert_eq!([0.5, 1.5, 2.5].map(|worst| outcome(worst).verdict), {
            use Verdict::{Different, Equivalent};
            [Equivalent, Equivalent, Different]
        });
        assert_eq!(
            [0.5, 1.5].map(|worst| outcome(worst).message.ends_with("Known limit: rounding.")),
            [false, true]
        );
        assert!(outcome(0.5).message.contains("Expected: nothing."));
    }

    #[test]
    fn a_brighter_lamp_is_not_the_same() {
        let scenes = [1.0, 1.01].map(|factor| with_light(&lamp(8.0 * factor)));
        let row = Case::same("x", "", scenes, 1e-3).check(1, 0);
        assert!(row.verdict == Standing::Differs && (row.error - 0.01).abs() < 1e-3, "{row:?}");
    }
}
