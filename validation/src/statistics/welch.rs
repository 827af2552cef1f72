//! The difference of two estimates with unequal and estimated variances.

use super::distributions::{student_quantile, student_two_sided};

/// A mean with the estimated variance of that mean and the degrees of freedom behind the estimate.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: f64,
    /// Variance of the mean (not of a sample).
    pub variance: f64,
    /// Degrees of freedom of `variance`; infinity where the variance is known exactly.
    pub degrees: f64,
}

impl Estimate {
    /// Mean, variance of the mean and n−1 degrees of freedom of independent `samples`.
    pub fn of(samples: impl IntoIterator<Item = f64>) -> Self {
        let [estimate] = Self::of_each(samples.into_iter().map(|sample| [sample]));
        estimate
    }

    /// Estimates of several quantities in one pass.
    pub fn of_each<const N: usize>(samples: impl IntoIterator<Item = [f64; N]>) -> [Self; N] {
        let (mut count, mut mean, mut squares) = (0.0, [0.0; N], [0.0; N]);
        for sample in samples {
            count += 1.0;
            for i in 0..N {
                let delta = sample[i] - mean[i];
                mean[i] += delta / count;
                squares[i] += delta * (sample[i] - mean[i]);
            }
        }
        let degrees = count - 1.0;
        std::array::from_fn(|i| Self { mean: mean[i], variance: squares[i] / (degrees * count), degrees })
    }
}

/// Welch's t test (Welch 1947) with the Welch–Satterthwaite degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Welch {
    /// Mean of the second estimate minus mean of the first.
    pub difference: f64,
    pub standard_error: f64,
    pub degrees: f64,
}

impl Welch {
    /// ν = (V₁ + V₂)² / (V₁²/ν₁ + V₂²/ν₂).
    pub fn new(first: Estimate, second: Estimate) -> Self {
        let variance = first.variance + second.variance;
        let square = |estimate: Estimate| estimate.variance * estimate.variance / estimate.degrees;
        let spread = square(first) + square(second);
        Self {
            difference: second.mean - first.mean,
            standard_error: variance.sqrt(),
            degrees: if spread > 0.0 { variance * variance / spread } else { f64::INFINITY },
        }
    }

    /// The signed statistic. Two equal noiseless means give 0, two different ones ±infinity.
    pub fn statistic(&self) -> f64 {
        if self.difference == 0.0 { 0.0 } else { self.difference / self.standard_error }
    }

    /// Two-sided p-value of "the means are equal".
    pub fn p_value(&self) -> f64 {
        student_two_sided(self.statistic(), self.degrees)
    }

    /// Half the width of the confidence interval that excludes the true value with probability `level`.
    pub fn half_width(&self, level: f64) -> f64 {
        if self.standard_error == 0.0 {
            0.0
        } else {
            student_quantile(level, self.degrees) * self.standard_error
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Stream, uniformity};

    #[test]
    fn agrees_with_a_worked_example() {
        // Two short lists; t and ν recomputed independently with Python's statistics module.
        let first = Estimate::of([27.5, 21.0, 19.0, 23.6, 17.0, 17.9]);
        let second = Estimate::of([27.1, 22.0, 20.8, 23.4, 23.4, 23.5, 25.8, 22.0]);
        let welch = Welch::new(first, second);
        assert!((first.mean - 21.0).abs() < 1e-12 && (second.mean - 23.5).abs() < 1e-12);
        assert!((first.variance - 15.724 / 6.0).abs() < 1e-12);
        assert!((second.variance - 4.294285714285715 / 8.0).abs() < 1e-12);
        assert!((welch.statistic() - 1.4069271288584282).abs() < 1e-12);
        assert!((welch.degrees - 7.046874533683051).abs() < 1e-12);
    }

    #[test]
    fn null_p_values_are_uniform() {
        let mut stream = Stream::named("welch null", 0);
        let p_values: Vec<f64> = (0..2000)
            .map(|_| {
                let first = Estimate::of((0..20).map(|_| stream.normal()));
                let second = Estimate::of((0..8).map(|_| 3.0 * stream.normal()));
                Welch::new(first, second).p_value()
            })
            .collect();
        assert!(uniformity(&p_values) > 1e-3);
    }

    #[test]
    fn without_noise_only_equality_passes() {
        let exact = |mean| Estimate { mean, variance: 0.0, degrees: f64::INFINITY };
        assert_eq!(Welch::new(exact(1.0), exact(1.0)).p_value(), 1.0);
        assert_eq!(Welch::new(exact(1.0), exact(1.5)).p_value(), 0.0);
        assert!(Welch::new(exact(1.0), exact(f64::NAN)).p_value().is_nan());
    }
}
