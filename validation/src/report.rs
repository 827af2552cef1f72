//! The outcome of a check, and its JSON document.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::statistics::Verdict;

/// The result of one check on one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The check's name, such as `chi2`.
    pub check: String,
    /// The subject that was checked; empty until the caller sets it with [`Outcome::of`].
    pub subject: String,
    pub verdict: Verdict,
    /// One sentence for a person with the finding and its place.
    pub message: String,
    /// Uniform under the null hypothesis; absent for deterministic checks.
    pub p_value: Option<f64>,
    /// Minimum detectable effect at 90 % power, in the unit the message names; absent for deterministic
    /// checks.
    pub detectable: Option<f64>,
    /// All other measured values, by name. A value that is not finite becomes `null` in JSON.
    pub figures: BTreeMap<String, f64>,
}

impl Outcome {
    /// An outcome without figures.
    pub fn new(check: &str, verdict: Verdict, message: impl Into<String>) -> Self {
        Self {
            check: check.to_string(),
            subject: String::new(),
            verdict,
            message: message.into(),
            p_value: None,
            detectable: None,
            figures: BTreeMap::new(),
        }
    }

    /// The same outcome, for the named subject.
    pub fn of(mut self, subject: impl Into<String>) -> Self {
        self.subject = subject.into();
        self
    }

    /// The same outcome with its p-value.
    pub fn p_value(mut self, p_value: f64) -> Self {
        self.p_value = Some(p_value);
        self
    }

    /// The same outcome with its minimum detectable effect.
    pub fn detectable(mut self, effect: f64) -> Self {
        self.detectable = Some(effect);
        self
    }

    /// The same outcome with one more figure.
    pub fn figure(mut self, name: &str, value: f64) -> Self {
        self.figures.insert(name.to_string(), value);
        self
    }
}

/// Several outcomes under one title.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    pub title: String,
    /// The worst verdict of all outcomes; inconclusive if there are none.
    pub verdict: Verdict,
    pub outcomes: Vec<Outcome>,
}

impl Report {
    /// Gathers `outcomes` and their common verdict.
    pub fn new(title: impl Into<String>, outcomes: Vec<Outcome>) -> Self {
        let verdict = Verdict::all(outcomes.iter().map(|outcome| outcome.verdict));
        Self { title: title.into(), verdict, outcomes }
    }

    /// The p-values of all statistical outcomes, for the ledger.
    pub fn p_values(&self) -> Vec<f64> {
        self.outcomes.iter().filter_map(|outcome| outcome.p_value).collect()
    }
}

/// `value` as an indented JSON document.
pub fn to_json(value: &impl Serialize) -> serde_json::Result<String> {
    serde_json::to_string_pretty(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_takes_the_worst_verdict_and_survives_json() {
        let good = Outcome::new("chi2", Verdict::Equivalent, "fine")
            .of("diffuse")
            .p_value(0.4)
            .figure("bins", 256.0);
        let bad = Outcome::new("weight", Verdict::Different, "off").detectable(0.01);
        let report = Report::new("bsdf", vec![good, bad]);
        assert_eq!(report.verdict, Verdict::Different);
        assert_eq!(report.p_values(), [0.4]);
        let text = to_json(&report).unwrap();
        assert!(text.contains("\"verdict\": \"different\""));
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report);
    }

    #[test]
    fn figures_that_are_not_finite_become_null() {
        let text = to_json(&Outcome::new("x", Verdict::Different, "").figure("mean", f64::NAN)).unwrap();
        assert!(text.contains("\"mean\": null"));
    }
}
