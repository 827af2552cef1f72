//! Minimum detectable effects at 90 % power.

use super::distributions::{chi_square_upper, normal_quantile, student_quantile};

/// The probability with which a "minimum detectable effect" is detected.
pub const POWER: f64 = 0.9;

/// Smallest true difference, in the unit of `standard_error`, that a two-sided test at `level` detects with
/// [`POWER`], if the standard error was estimated with `degrees` degrees of freedom (infinity if it is
/// known).
pub fn detectable_difference(standard_error: f64, level: f64, degrees: f64) -> f64 {
    (student_quantile(level, degrees) + student_quantile(2.0 * (1.0 - POWER), degrees)) * standard_error
}

/// Factor by which more samples make a comparison without a true difference equivalent with [`POWER`]: the
/// interval's half width shrinks with √k and must leave room for the noise of its centre on both sides.
///
/// `parts` comparisons must be decided together, each at `level`. The factor is at least 2, since less would
/// hardly change the outcome.
pub fn more_samples(standard_error: f64, level: f64, margin: f64, parts: usize) -> f64 {
    let miss = (1.0 - POWER) / parts.max(1) as f64;
    let reach = (normal_quantile(0.5 * level) + normal_quantile(0.5 * miss)) * standard_error / margin;
    (reach * reach).max(2.0)
}

/// Smallest root mean square relative error of the expected bin probabilities (Cohen's w) that Pearson's test
/// with `samples` samples and `degrees` degrees of freedom detects with [`POWER`] at `level`.
///
/// The statistic is then non-central χ² with λ = n w², mean k + λ and variance 2(k + 2λ), taken as normal.
pub fn detectable_chi_square(samples: f64, degrees: f64, level: f64) -> f64 {
    let critical = bisect(0.0, 10.0 * degrees + 1000.0, |x| chi_square_upper(x, degrees) - level);
    let reach = normal_quantile(1.0 - POWER);
    let lambda = bisect(0.0, 100.0 * (critical + 1.0), |lambda| {
        critical - degrees - lambda + reach * (2.0 * (degrees + 2.0 * lambda)).sqrt()
    });
    (lambda / samples).sqrt()
}

/// Root of a `function` that falls through zero between `low` and `high`.
fn bisect(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if function(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Estimate, Interval, Stream, Verdict, Welch};

    #[test]
    fn the_detectable_difference_is_detected_nine_times_in_ten() {
        let mut stream = Stream::named("detectable difference", 0);
        let effect = detectable_difference(1.0, 0.01, f64::INFINITY);
        let critical = normal_quantile(0.005);
        let found = (0..4000).filter(|_| (stream.normal() + effect).abs() > critical).count();
        // Three standard errors of a share of 0.9 in 4000 trials: 0.014.
        assert!((found as f64 / 4000.0 - 0.9).abs() < 0.015, "{found}");
    }

    #[test]
    fn of_twelve_values_the_detectable_difference_is_larger() {
        let mut stream = Stream::named("detectable difference of few", 0);
        let critical = student_quantile(0.01, 11.0);
        let effect = detectable_difference(1.0 / 12f64.sqrt(), 0.01, 11.0);
        let found = (0..4000).filter(|_| {
            let estimate = Estimate::of((0..12).map(|_| stream.normal() + effect));
            estimate.mean.abs() > critical * estimate.variance.sqrt()
        });
        // The sum of two of Student's quantiles is an approximation; with the normal quantiles the share
        // would be 0.75.
        let share = found.count() as f64 / 4000.0;
        assert!((share - 0.9).abs() < 0.035, "{share}");
    }

    #[test]
    fn the_detectable_chi_square_is_detected_nine_times_in_ten() {
        let (bins, samples) = (64, 1e6);
        let effect = detectable_chi_square(samples, (bins - 1) as f64, 1e-3);
        let mut stream = Stream::named("detectable chi-square", 0);
        let shift = effect * (samples / bins as f64).sqrt();
        let found = (0..2000).filter(|_| {
            let normals: Vec<f64> = (0..bins).map(|_| stream.normal()).collect();
            let mean = normals.iter().sum::<f64>() / bins as f64;
            // Half of the bins are too large, half too small: w = effect, and the total is kept.
            let sign = |bin| if bin < bins / 2 { 1.0 } else { -1.0 };
            let statistic: f64 =
                normals.iter().enumerate().map(|(b, z)| z - mean + sign(b) * shift).map(|z| z * z).sum();
            chi_square_upper(statistic, (bins - 1) as f64) < 1e-3
        });
        let share = found.count() as f64 / 2000.0;
        // 0.02 is three standard errors; the rest is the normal approximation of the non-central
        // distribution.
        assert!((share - 0.9).abs() < 0.03, "{share}");
    }

    #[test]
    fn that_many_more_samples_settle_it() {
        let (error, margin) = (0.01, 0.0025);
        let factor = more_samples(error, 0.01, margin, 1);
        let mut stream = Stream::named("more samples", 0);
        let settled = (0..2000).filter(|_| {
            let standard_error = error / factor.sqrt();
            let exact = Estimate { mean: 1.0, variance: 0.0, degrees: f64::INFINITY };
            let noisy = Estimate {
                mean: 1.0 + standard_error * stream.normal(),
                variance: standard_error * standard_error,
                degrees: f64::INFINITY,
            };
            let welch = Welch::new(exact, noisy);
            Interval::around(noisy.mean, welch.half_width(0.01)).verdict(1.0, margin) == Verdict::Equivalent
        });
        let share = settled.count() as f64 / 2000.0;
        assert!((share - 0.9).abs() < 0.025, "{share}");
    }
}
