//! Image level: the ratio of the two means of a channel.

use serde::Serialize;

use super::{pair::Pair, tiles::informed};
use crate::statistics::{
    Estimate, Interval, Verdict, Welch,
    distributions::student_quantile,
    power::{detectable_difference, more_samples},
};

/// The means of one channel over all pixels whose variance is known.
#[derive(Clone, Debug, Serialize)]
pub struct MeanComparison {
    pub mean_a: f64,
    pub mean_b: f64,
    /// `mean_b` / `mean_a`.
    pub ratio: f64,
    /// Fieller's confidence interval of the ratio; its ends are infinite if `mean_a` does not differ
    /// significantly from zero.
    pub interval: Interval,
    /// p-value of "the means are equal".
    pub p_value: f64,
    pub verdict: Verdict,
    /// Smallest true deviation of the ratio from 1 that the test detects with 90 % power.
    pub detectable: f64,
    /// Factor by which more samples would decide an inconclusive comparison.
    pub more_samples: Option<f64>,
}

/// Sums over a set of pixels of means, variances and squared variances of both sides.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub count: f64,
    pub a: Side,
    pub b: Side,
}

/// The sums of one image in [`Sums`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    pub mean: f64,
    pub variance: f64,
    pub squared_variance: f64,
}

impl Side {
    fn add(&mut self, mean: f64, variance: f64) {
        self.mean += mean;
        self.variance += variance;
        self.squared_variance += variance * variance;
    }

    /// The mean of `count` pixels. Each pixel's variance counts as one degree of freedom, however many
    /// samples it was estimated from, so Welch and Satterthwaite's ν = (ΣV)²/ΣV² is the number of pixels that
    /// effectively contribute the noise: hundreds where the noise is even, few where a firefly dominates. The
    /// n−1 degrees of freedom of a pixel would hold for normal samples only; with heavy tails the variance
    /// estimate of a single pixel is unreliable, and unusual values are rightly no longer significant.
    ///
    /// The variance is `shared` times that of independent pixels, of which there are as many times fewer.
    pub fn estimate(&self, count: f64, shared: f64) -> Estimate {
        let degrees = self.variance * self.variance / (self.squared_variance * shared);
        let degrees = if self.squared_variance > 0.0 { degrees } else { f64::INFINITY };
        Estimate { mean: self.mean / count, variance: self.variance * shared / (count * count), degrees }
    }
}

impl Sums {
    pub fn over(pixels: impl Iterator<Item = super::pair::Pixel>) -> Self {
        pixels.filter(|pixel| pixel.is_testable()).fold(Sums::default(), |mut sums, pixel| {
            sums.count += 1.0;
            sums.a.add(pixel.a, pixel.variance_a);
            sums.b.add(pixel.b, pixel.variance_b);
            sums
        })
    }
}

/// What the noise of a pair of channels is like.
#[derive(Clone, Copy, Debug)]
pub(super) struct NoiseOf {
    /// How many times as noisy b typically is as a; `None` without noise.
    pub ratio: Option<f64>,
    /// How many times the variance of a mean is that of independent pixels.
    pub shared: f64,
}

/// Levels and the margin of the ratio of means.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Of the interval.
    pub level: f64,
    /// Of the test, the level left after correction for the other tests of the same images.
    pub corrected: f64,
    pub margin: f64,
    /// How many channels must all lie within it.
    pub channels: usize,
}

/// Compares the means of `pair`: equivalent if the interval of the ratio lies within 1 ± the margin, else different
/// if equality is rejected. What either has missed of rare events the other's variance tells, as of tiles.
pub(super) fn compare(
    pair: &Pair,
    noise: NoiseOf,
    Limits { level, corrected, margin, channels }: Limits,
) -> MeanComparison {
    let sums = Sums::over(pair.pixels().map(|(_, _, pixel)| pixel));
    if sums.count == 0.0 {
        return without_noise(pair);
    }
    let (a, b) = informed(sums.a, sums.b, noise.ratio);
    let (a, b) = (a.estimate(sums.count, noise.shared), b.estimate(sums.count, noise.shared));
    let welch = Welch::new(a, b);
    let quantile = student_quantile(level, welch.degrees);
    let interval = fieller(a, b, quantile);
    let p_value = welch.p_value();
    let verdict = if interval.within(1.0, margin) {
        Verdict::Equivalent
    } else if p_value <= corrected {
        Verdict::Different
    } else {
        Verdict::Inconclusive
    };
    let relative_error = welch.standard_error / a.mean.abs();
    let open = verdict == Verdict::Inconclusive && relative_error.is_finite();
    MeanComparison {
        mean_a: a.mean,
        mean_b: b.mean,
        ratio: b.mean / a.mean,
        interval,
        p_value,
        verdict,
        detectable: detectable_difference(relative_error, corrected, welch.degrees),
        more_samples: open.then(|| more_samples(relative_error, level, margin, channels)),
    }
}

/// The means of a channel of whose noise nothing is known. Where values differ [`Faults`](super::Faults) say so;
/// where none does, there is nothing to tell apart.
fn without_noise(pair: &Pair) -> MeanComparison {
    let count = (pair.width * pair.height) as f64;
    let mean = |value: fn(&super::pair::Pixel) -> f64| {
        pair.pixels().map(|(_, _, pixel)| value(&pixel)).sum::<f64>() / count
    };
    let (mean_a, mean_b) = (mean(|pixel| pixel.a), mean(|pixel| pixel.b));
    let ratio = if mean_a == mean_b { 1.0 } else { mean_b / mean_a };
    MeanComparison {
        mean_a,
        mean_b,
        ratio,
        interval: Interval::around(ratio, 0.0),
        p_value: 1.0,
        verdict: Verdict::Equivalent,
        detectable: 0.0,
        more_samples: None,
    }
}

/// All ρ with (B − ρA)² ≤ q² (V_B + ρ² V_A): the confidence set of a ratio of means (Fieller 1954). It is an
/// interval only if A differs from 0 at the same level. Two exact zeros have the ratio 1.
fn fieller(a: Estimate, b: Estimate, quantile: f64) -> Interval {
    if a.mean == b.mean && a.variance == 0.0 && b.variance == 0.0 {
        return Interval::around(1.0, 0.0);
    }
    let square = quantile * quantile;
    let leading = a.mean * a.mean - square * a.variance;
    let constant = b.mean * b.mean - square * b.variance;
    let product = a.mean * b.mean;
    if leading.is_nan() || leading <= 0.0 {
        return Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
    }
    let root = (product * product - leading * constant).max(0.0).sqrt();
    Interval { low: (product - root) / leading, high: (product + root) / leading }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Stream;

    #[test]
    fn fieller_covers_the_true_ratio() {
        let mut stream = Stream::named("fieller", 0);
        let covered = (0..4000).filter(|_| {
            let estimate = |mean: f64, stream: &mut Stream| Estimate {
                mean: mean + 0.2 * stream.normal(),
                variance: 0.04,
                degrees: f64::INFINITY,
            };
            let (a, b) = (estimate(1.0, &mut stream), estimate(1.5, &mut stream));
            fieller(a, b, 1.959963984540054).contains(1.5)
        });
        let share = covered.count() as f64 / 4000.0;
        // Three standard errors of a share of 0.95.
        assert!((share - 0.95).abs() < 0.0104, "{share}");
    }

    #[test]
    fn a_ratio_to_nothing_is_unbounded() {
        let noisy = Estimate { mean: 0.01, variance: 1.0, degrees: 10.0 };
        assert_eq!(fieller(noisy, noisy, 2.0).high, f64::INFINITY);
        let zero = Estimate { mean: 0.0, variance: 0.0, degrees: f64::INFINITY };
        assert_eq!(fieller(zero, zero, 2.0), Interval::around(1.0, 0.0));
        assert_eq!(fieller(zero, Estimate { mean: 1.0, ..zero }, 2.0).high, f64::INFINITY);
    }
}
