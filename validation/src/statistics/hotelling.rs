//! Is the mean of a random vector what it should be? Hotelling's T².

use statrs::function::beta;

/// What became of the components of a vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Components {
    /// Components that vary independently of those before them.
    pub rank: usize,
    /// Those whose mean is near enough to normal, and whose expected mean is known well enough, to be judged.
    pub used: usize,
    /// n Σ z², z being the means of the used components in standard deviations.
    pub statistic: f64,
    pub p_value: f64,
}

/// Variance left to a component by those before it, relative to its own, below which it is one of their sums.
const DEPENDENT: f64 = 1e-4;

/// Largest skewness and excess kurtosis of a *mean* that counts as normal: third and fourth cumulants over
/// n^½ and n. The second says that at least some 500 samples carry the variance.
const SKEWED: f64 = 0.05;
const HEAVY: f64 = 0.002;

/// Most that the error of the expected mean may add to the statistic of a component, which is 1 in
/// expectation.
const BLURRED: f64 = 0.01;

/// A component whose variance is this many times that of the samples has events that the samples have missed;
/// where skewness and kurtosis are small, variances of samples are known far better.
const MISSED: f64 = 1.5;

/// What the mean and the variances of vectors should be.
#[derive(Clone, Debug)]
pub struct Expected<const N: usize> {
    pub mean: [f64; N],
    /// Of each component of the mean.
    pub error: f64,
    /// At least this, or 0 where it is not known.
    pub variance: [f64; N],
    /// Of other samples, many more: what these have met that the judged ones have missed.
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
/// A pivoted Cholesky factor of the sample covariance turns the components into uncorrelated ones of unit
/// variance. Those whose means are far from normal, because few samples carry all of their variance, are left
/// out: their T² would reject honest subjects. The choice looks at variance, skewness and kurtosis and not at
/// the mean. Samples that have missed a rare event look normal, and have a wrong mean and too small a
/// variance: so T² is divided by how many times larger the expected variance is. Of what is left of a
/// component when the others have explained most of it, that says nothing: there other samples are asked, and
/// where they vary more it is left out as well. Then T²(n − p)/(p(n − 1)) follows Fisher's F with p and n − p
/// degrees of freedom (Hotelling 1931).
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
    // Column j of what whitens is that of the unit vector along j.
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
    // For so many degrees of freedom the beta function's fraction ends too early; χ² differs by O(p/n) there.
    if count - used > 2000.0 {
        let shrunk = (count - used) * -libm::log(x);
        return super::distributions::chi_square_upper(shrunk, used);
    }
    beta::beta_reg(0.5 * (count - used), 0.5 * used, x)
}

/// How much independent errors of size `error` in all components change the whitened ones.
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

/// The order of pivots and the rows of the lower factor in that order, until what is left depends on what was
/// taken.
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
                // The last is a sum of others, and must not count.
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
        // A fifth of a standard deviation of `a`, but twice that of what `b` leaves unexplained.
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
        // The event is missed by e⁻¹ of them.
        assert!(judged.len() > 100 && judged.iter().all(|p| *p > 0.01), "{judged:?}");
        // A mean that is wrong by ten of what all events together scatter.
        assert!((0..400).filter_map(|seed| p_value(seed, 1.011)).all(|p| p < 1e-9));
    }

    /// The second component is the first but for a rare event, of which neither variance nor kurtosis of
    /// those that missed it tells.
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
