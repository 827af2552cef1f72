//! Hotelling's T² test of the mean of a random vector.

use statrs::function::beta;

/// The result of the test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Components {
    /// Number of components that are linearly independent of those before them.
    pub rank: usize,
    /// Number of those that are tested: their mean is near enough to normal, and their expected mean is known
    /// accurately enough.
    pub used: usize,
    /// n Σ z², where z are the means of the tested components in standard deviations.
    pub statistic: f64,
    pub p_value: f64,
}

/// Conditional variance of a component given those before it, relative to its own variance, below which it
/// counts as a linear combination of them.
const DEPENDENT: f64 = 1e-4;

/// Largest skewness of a *mean* that counts as normal: the third standardised cumulant over n^½.
const SKEWED: f64 = 0.05;
/// Largest excess kurtosis of a *mean* that counts as normal: the fourth standardised cumulant over n. It
/// implies that at least some 500 samples contribute to the variance.
const HEAVY: f64 = 0.002;

/// Largest contribution of the error of the expected mean to the statistic of a component, whose expectation
/// is 1.
const BLURRED: f64 = 0.01;

/// Ratio of a component's expected variance to its sample variance from which the samples have missed rare
/// events; where skewness and kurtosis are small, sample variances are far more accurate than that.
const MISSED: f64 = 1.5;

/// The expected mean and variances of the vectors.
#[derive(Clone, Debug)]
pub struct Expected<const N: usize> {
    pub mean: [f64; N],
    /// Bound on the error of each component of the mean.
    pub error: f64,
    /// Lower bound on the variance of each component; 0 where it is unknown.
    pub variance: [f64; N],
    /// Covariance of other, more numerous samples, which contain rare events that the tested samples may have
    /// missed.
    pub others: Option<Covariance>,
}

/// The lower triangle of a covariance matrix, by rows.
#[derive(Clone, Debug)]
pub struct Covariance(Vec<Vec<f64>>);

impl Covariance {
    pub fn of<const N: usize>(samples: impl Iterator<Item = [f64; N]>) -> Self {
        Self(covariance(samples).2)
    }

    /// The variance of Σ wᵢ xᵢ.
    fn along(&self, w: &[f64]) -> f64 {
        let row = |i: usize| {
            let beside: f64 = (0..i).map(|j| self.0[i][j] * w[j]).sum();
            w[i] * (2.0 * beside + self.0[i][i] * w[i])
        };
        (0..w.len()).map(row).sum()
    }
}

/// Tests whether the vectors that `samples` yields (the same ones at each call) have the expected mean.
///
/// A pivoted Cholesky factor of the sample covariance whitens the components: they become uncorrelated and
/// have unit variance. Those whose means are far from normal, because few samples contribute all of their
/// variance, are left out: their T² would reject correct subjects. The selection depends on variance,
/// skewness and kurtosis and not on the mean. Samples that have missed a rare event look normal, and have a
/// wrong mean and too small a variance: so T² is divided by the ratio of the expected to the sample variance.
/// For the remainder of a component that the others mostly explain, that ratio is not informative: there the
/// other samples are used, and if their variance is larger the component is left out as well. Then T²(n −
/// p)/(p(n − 1)) follows Fisher's F with p and n − p degrees of freedom (Hotelling 1931).
pub fn hotelling<const N: usize, I: Iterator<Item = [f64; N]>>(
    samples: impl Fn() -> I,
    expected: &Expected<N>,
) -> Components {
    let (count, mean, covariance) = covariance(samples());
    let ratios = (0..N).map(|i| expected.variance[i] / covariance[i][i]);
    let missed = ratios.filter(|ratio| ratio.is_finite() && *ratio > MISSED).fold(1.0, f64::max);
    let (order, factor) = cholesky(covariance);
    let rank = order.len();
    let whiten = |vector: &[f64; N]| {
        let mut z = vec![0.0; rank];
        for i in 0..rank {
            let known: f64 = (0..i).map(|j| factor[i][j] * z[j]).sum();
            z[i] = (vector[order[i]] - known) / factor[i][i];
        }
        z
    };
    let mut powers = vec![[0.0; 2]; rank];
    for sample in samples() {
        let centred: [f64; N] = std::array::from_fn(|i| sample[i] - mean[i]);
        for (powers, z) in powers.iter_mut().zip(whiten(&centred)) {
            powers[0] += z * z * z;
            powers[1] += z * z * z * z;
        }
    }
    // Column j of the whitening matrix is the whitened unit vector along j.
    let columns: Vec<Vec<f64>> =
        (0..N).map(|j| whiten(&std::array::from_fn(|i| f64::from(u8::from(i == j))))).collect();
    let elsewhere = |z: usize| {
        let weights: Vec<f64> = columns.iter().map(|column| column[z]).collect();
        expected.others.as_ref().map_or(1.0, |others| others.along(&weights))
    };
    let reach = reach(&factor, rank, expected.error);
    let usable = powers.iter().enumerate().map(|(z, [third, fourth])| {
        near_normal(third / count, fourth / count - 3.0, count)
            && count * reach[z] * reach[z] <= BLURRED
            && elsewhere(z) <= MISSED
    });
    let shift = whiten(&std::array::from_fn(|i| mean[i] - expected.mean[i]));
    let judged: Vec<f64> = shift.into_iter().zip(usable).filter(|part| part.1).map(|part| part.0).collect();
    let (used, statistic) = (judged.len(), count * judged.iter().fold(0.0, |sum, z| sum + z * z) / missed);
    let broken = mean.iter().chain(&expected.mean).any(|value| !value.is_finite());
    let p_value = if broken { f64::NAN } else { upper(statistic, used as f64, count) };
    Components { rank, used, statistic, p_value }
}

/// Whether the mean of `count` samples of this skewness and excess kurtosis counts as normal.
pub fn near_normal(skewness: f64, kurtosis: f64, count: f64) -> bool {
    skewness.abs() / count.sqrt() <= SKEWED && kurtosis.abs() / count <= HEAVY
}

/// P(T² ≥ `statistic`), by the incomplete beta function.
fn upper(statistic: f64, used: f64, count: f64) -> f64 {
    if used == 0.0 || statistic == 0.0 {
        return 1.0;
    }
    // With F = T²(n − p)/(p(n − 1)) the argument d₂/(d₂ + d₁F) is (n − 1)/(n − 1 + T²).
    let x = (count - 1.0) / (count - 1.0 + statistic);
    // For that many degrees of freedom the continued fraction of the beta function has too few terms; χ²
    // differs by O(p/n) there.
    if count - used > 2000.0 {
        let shrunk = (count - used) * -libm::log(x);
        return super::distributions::chi_square_upper(shrunk, used);
    }
    beta::beta_reg(0.5 * (count - used), 0.5 * used, x)
}

/// Standard deviation of the whitened components if all components have independent errors of size `error`.
fn reach(factor: &[Vec<f64>], rank: usize, error: f64) -> Vec<f64> {
    let mut z = vec![0.0f64; rank];
    for i in 0..rank {
        let known: f64 = (0..i).map(|j| factor[i][j] * z[j]).map(|part| part * part).sum();
        z[i] = (error * error + known).sqrt() / factor[i][i];
    }
    z
}

fn covariance<const N: usize>(samples: impl Iterator<Item = [f64; N]>) -> (f64, [f64; N], Vec<Vec<f64>>) {
    let (mut count, mut mean, mut sums) = (0.0, [0.0; N], vec![vec![0.0; N]; N]);
    for sample in samples {
        count += 1.0;
        let before: [f64; N] = std::array::from_fn(|i| sample[i] - mean[i]);
        mean.iter_mut().zip(before).for_each(|(mean, delta)| *mean += delta / count);
        for i in 0..N {
            let after = sample[i] - mean[i];
            sums[i].iter_mut().zip(&before[..=i]).for_each(|(sum, delta)| *sum += delta * after);
        }
    }
    sums.iter_mut().flatten().for_each(|sum| *sum /= count - 1.0);
    (count, mean, sums)
}

/// The order of pivots and the rows of the lower factor in that order, up to the components that are linear
/// combinations of the chosen ones.
fn cholesky(covariance: Vec<Vec<f64>>) -> (Vec<usize>, Vec<Vec<f64>>) {
    let size = covariance.len();
    let at = |i: usize, j: usize| if i >= j { covariance[i][j] } else { covariance[j][i] };
    let mut left: Vec<f64> = (0..size).map(|i| at(i, i)).collect();
    let mut columns: Vec<Vec<f64>> = vec![vec![]; size];
    let mut order: Vec<usize> = vec![];
    loop {
        let share = |i: usize| if at(i, i) > 0.0 { left[i] / at(i, i) } else { 0.0 };
        let rest = (0..size).filter(|i| !order.contains(i) && share(*i) > DEPENDENT);
        let Some(pivot) = rest.max_by(|&i, &j| left[i].total_cmp(&left[j])) else { break };
        let root = left[pivot].sqrt();
        let row = columns[pivot].clone();
        for i in 0..size {
            let known: f64 = columns[i].iter().zip(&row).map(|(a, b)| a * b).sum();
            let entry = if i == pivot { root } else { (at(i, pivot) - known) / root };
            columns[i].push(entry);
            left[i] -= entry * entry;
        }
        order.push(pivot);
    }
    let rows = order.iter().map(|&i| columns[i].clone()).collect();
    (order, rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Stream, uniformity};

    fn expected<const N: usize>(mean: [f64; N]) -> Expected<N> {
        Expected { mean, error: 0.0, variance: [0.0; N], others: None }
    }

    fn correlated(seed: u64, count: usize, shift: f64) -> Components {
        let samples = || {
            let mut stream = Stream::named("hotelling", seed);
            (0..count).map(move |_| {
                let [a, b, c] = [stream.normal(), stream.normal(), stream.exponential() - 1.0];
                // The last component is a linear combination of others, and must not count.
                [a + shift, 0.9 * a + 0.1 * b, 5.0 * c, a + shift + 5.0 * c]
            })
        };
        hotelling(samples, &expected([0.0; 4]))
    }

    #[test]
    fn p_values_are_uniform_for_few_and_for_many_samples() {
        for (count, start) in [(400, 0), (3000, 10_000)] {
            let p_values: Vec<f64> = (0..500).map(|n| correlated(start + n, count, 0.0).p_value).collect();
            assert!(uniformity(&p_values) > 1e-3, "{count}: {}", uniformity(&p_values));
        }
        assert_eq!(correlated(0, 3000, 0.0).rank, 3);
    }

    #[test]
    fn a_shift_is_found_through_the_correlation() {
        // The shift is a fifth of a standard deviation of `a`, but twice the conditional standard deviation
        // given the second component.
        assert!(correlated(1, 3000, 0.2).p_value < 1e-9);
    }

    #[test]
    fn samples_that_missed_what_is_rare_are_no_evidence_either() {
        let expected =
            |mean: f64| Expected { mean: [mean], error: 0.0, variance: [1e-4 + 1e-3], others: None };
        let p_value = |seed: u64, mean: f64| {
            let draws = || {
                let mut stream = Stream::named("rare", seed);
                (0..1024).map(move |_| [1.0 + 0.01 * stream.normal() + f64::from(stream.uniform() < 1e-3)])
            };
            let found = hotelling(draws, &expected(mean));
            (found.used > 0).then_some(found.p_value)
        };
        let judged: Vec<f64> = (0..400).filter_map(|seed| p_value(seed, 1.001)).collect();
        // A share e⁻¹ of the runs misses the event.
        assert!(judged.len() > 100 && judged.iter().all(|p| *p > 0.01), "{judged:?}");
        // The mean is wrong by ten standard deviations of the events' total contribution.
        assert!((0..400).filter_map(|seed| p_value(seed, 1.011)).all(|p| p < 1e-9));
    }

    /// The second component equals the first except for a rare event, which neither the variance nor the
    /// kurtosis of samples that missed it shows.
    #[test]
    fn what_others_explain_may_hide_what_is_rare() {
        let draws = |seed: u64, count: usize| {
            let mut stream = Stream::named("hidden", seed);
            (0..count).map(move |_| {
                let (a, b) = (stream.normal(), stream.normal());
                [a, a + 0.02 * b + f64::from(stream.uniform() < 1e-3)]
            })
        };
        let others = Some(Covariance::of(draws(1_000_000, 1 << 14)));
        let mean = [0.0, 1e-3];
        let p_values = |others: &Option<Covariance>| {
            let expected = Expected { others: others.clone(), ..expected(mean) };
            let judge = |seed: u64| hotelling(|| draws(seed, 1024), &expected).p_value;
            (0..500).map(judge).collect::<Vec<f64>>()
        };
        assert!(uniformity(&p_values(&None)) < 1e-3);
        let p_values = p_values(&others);
        assert!(uniformity(&p_values) > 1e-3, "{}", uniformity(&p_values));
    }

    #[test]
    fn one_lucky_sample_is_no_evidence() {
        let samples = || (0..10_000).map(|i| [f64::from(i == 5000), if i % 2 == 0 { 1.0 } else { -1.0 }]);
        let found = hotelling(samples, &expected([0.0; 2]));
        assert_eq!((found.rank, found.used), (2, 1));
        assert!(found.p_value > 0.9);
    }
}
