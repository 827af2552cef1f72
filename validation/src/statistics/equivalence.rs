//! Equivalence tests with three verdicts, instead of mere non-rejection.

use serde::{Deserialize, Serialize};

/// The conclusion of a test. "Not shown to differ" is [`Verdict::Inconclusive`] unless the interval lies in
/// the margin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Shown to agree within the stated margin.
    Equivalent,
    /// Too little evidence for either verdict.
    Inconclusive,
    /// Shown to differ.
    Different,
}

impl Verdict {
    /// The verdict on several conditions that must all hold: the worst of them; inconclusive if there are
    /// none.
    pub fn all(verdicts: impl IntoIterator<Item = Verdict>) -> Verdict {
        verdicts.into_iter().max().unwrap_or(Verdict::Inconclusive)
    }

    /// Process exit code: 0 equivalent, 1 different, 3 inconclusive.
    pub fn exit_code(self) -> u8 {
        match self {
            Verdict::Equivalent => 0,
            Verdict::Different => 1,
            Verdict::Inconclusive => 3,
        }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str(match self {
            Verdict::Equivalent => "equivalent",
            Verdict::Inconclusive => "inconclusive",
            Verdict::Different => "different",
        })
    }
}

/// A confidence interval. Two one-sided tests at level α/2 (Schuirmann 1987) accept exactly when the 1 − α
/// interval lies inside the margin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// `centre` ± `half_width`.
    pub fn around(centre: f64, half_width: f64) -> Self {
        Self { low: centre - half_width, high: centre + half_width }
    }

    /// True if `value` lies inside; false if an end is NaN.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// True if the whole interval lies within `target` ± `margin`; false if an end is NaN.
    pub fn within(&self, target: f64, margin: f64) -> bool {
        target - margin <= self.low && self.high <= target + margin
    }

    /// True if part of the interval lies within `target` ± `margin`; false if an end is NaN.
    pub fn meets(&self, target: f64, margin: f64) -> bool {
        self.low <= target + margin && target - margin <= self.high
    }

    /// Equivalent if inside the margin, else different if it excludes the target, else inconclusive. A
    /// difference that is significant but smaller than the margin is therefore equivalent; an interval with
    /// NaN is different.
    pub fn verdict(&self, target: f64, margin: f64) -> Verdict {
        if self.within(target, margin) {
            Verdict::Equivalent
        } else if self.contains(target) {
            Verdict::Inconclusive
        } else {
            Verdict::Different
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_answers() {
        assert_eq!(Interval::around(1.001, 0.0005).verdict(1.0, 0.0025), Verdict::Equivalent);
        assert_eq!(Interval::around(1.001, 0.01).verdict(1.0, 0.0025), Verdict::Inconclusive);
        assert_eq!(Interval::around(0.98, 0.01).verdict(1.0, 0.0025), Verdict::Different);
        assert_eq!(Interval::around(f64::NAN, 0.01).verdict(1.0, 0.0025), Verdict::Different);
    }

    #[test]
    fn the_worst_answer_counts_and_silence_is_no_pass() {
        use Verdict::*;
        assert_eq!(Verdict::all([Equivalent, Inconclusive]), Inconclusive);
        assert_eq!(Verdict::all([Different, Inconclusive, Equivalent]), Different);
        assert_eq!(Verdict::all([]), Inconclusive);
    }
}
