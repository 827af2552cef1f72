//! The statistics behind every verdict, each with the derivation or the source of its formula.
//!
//! To add a test: compute a p-value that is uniform (or conservative) under the null hypothesis, state the
//! smallest effect it finds nine times in ten ([`power`]), and show both on synthetic data.

pub mod binomial;
pub mod distributions;
pub mod equivalence;
pub mod hotelling;
pub mod multiplicity;
pub mod power;
pub mod seed;
pub mod uniformity;
pub mod welch;

pub use equivalence::{Interval, Verdict};
pub use multiplicity::{benjamini_hochberg, holm, sidak};
pub use seed::{Stream, seed_for};
pub use uniformity::uniformity;
pub use welch::{Estimate, Welch};

/// The larger size of two numbers; a NaN is larger than any, where `f64::max` would pass over it.
pub fn worst_of(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.abs().max(b.abs()) }
}

/// The smaller of two p-values; NaN, which no test gives that was answered, if either is.
pub fn least_of(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }
}

#[cfg(test)]
mod tests {
    use super::{least_of, worst_of};

    #[test]
    fn nothing_is_worse_than_what_is_not_a_number() {
        assert!(worst_of(f64::NAN, 1.0).is_nan() && worst_of(1.0, f64::NAN).is_nan());
        assert!(least_of(f64::NAN, 1.0).is_nan() && least_of(1.0, f64::NAN).is_nan());
        assert_eq!(least_of(1.0, 0.25), 0.25);
        assert_eq!([worst_of(-3.0, 2.0), worst_of(0.0, f64::INFINITY)], [3.0, f64::INFINITY]);
    }
}
