//! The scatter of an image's mean from one batch of samples to the next.
//!
//! Where samples count for several pixels, all samples of a number lie at the same place within their pixels
//! (see [`super::spread`]). Along a straight edge between light and dark, parallel to rows or columns, they
//! fall on the same side of it together, so errors are alike all over the image, which no sum over pixels of
//! their own variances can tell. The means of the whole image over batches of samples can: they are
//! independent estimates of one number (method of batch means).

use crate::film::BLOCK;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Fewer batches than this say nothing about a variance.
const FEWEST: usize = 4;

/// Most batches: with more, neighbours become one. Samples of a low-discrepancy sequence are better the longer
/// a batch is, and the variance of the variance, 2/(batches − 1) of its square, is small enough.
const MOST: usize = 32;

/// Samples of the whole image in batches, each as long as all others: a power of two of [`BLOCK`]s.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BatchMeans {
    /// Samples of a batch.
    length: u64,
    /// By their number: the first sample of a batch divided by its length.
    batches: BTreeMap<u64, Batch>,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Batch {
    /// Sample numbers of which it has all pixels.
    samples: u64,
    /// Sums over samples and pixels, of the first three channels.
    #[serde(with = "super::bits")]
    sums: [f64; 3],
}

impl Default for BatchMeans {
    fn default() -> Self {
        Self { length: BLOCK, batches: BTreeMap::new() }
    }
}

/// A variance, and how many independent squares it is the mean of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Variance of the sum over all pixels, summed over channels.
    pub of_sum: f64,
    pub degrees: f64,
}

impl BatchMeans {
    /// Adds one sample of every pixel, by the sums over pixels of its channels.
    pub fn add(&mut self, sample: u64, sums: [f64; 3]) {
        self.batches.entry(sample / self.length).or_default().add(1, sums);
        if self.batches.len() > MOST {
            self.length *= 2;
            for (number, batch) in std::mem::take(&mut self.batches) {
                self.batches.entry(number / 2).or_default().add(batch.samples, batch.sums);
            }
        }
    }

    /// Scatter of the mean over all samples of the sum over pixels; `None` of too few batches. Those that are
    /// not complete are left out.
    pub fn scatter(&self) -> Option<Scatter> {
        let complete = self.batches.values().filter(|batch| batch.samples == self.length);
        let means: Vec<[f64; 3]> =
            complete.map(|batch| batch.sums.map(|sum| sum / self.length as f64)).collect();
        let count = means.len() as f64;
        let of_channel = |c: usize| {
            let mean = means.iter().map(|batch| batch[c]).sum::<f64>() / count;
            means.iter().map(|batch| (batch[c] - mean) * (batch[c] - mean)).sum::<f64>()
        };
        let squares: f64 = (0..3).map(of_channel).sum();
        let scatter = Scatter { of_sum: squares / (count - 1.0) / count, degrees: count - 1.0 };
        (means.len() >= FEWEST).then_some(scatter)
    }
}

impl Batch {
    fn add(&mut self, samples: u64, sums: [f64; 3]) {
        self.samples += samples;
        self.sums.iter_mut().zip(sums).for_each(|(sum, more)| *sum += more);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::{Pcg32, rand_core::Rng};

    /// Of so many samples from one on, each of three channels that know nothing of one another.
    fn of(samples: std::ops::Range<u64>, rng: &mut Pcg32) -> BatchMeans {
        let mut means = BatchMeans::default();
        let mut uniform = || f64::from(rng.next_u32()) / 4294967296.0;
        samples.for_each(|sample| means.add(sample, [uniform(), uniform(), 5.0]));
        means
    }

    #[test]
    fn the_scatter_is_that_of_the_mean_of_independent_samples() {
        let mut rng = Pcg32::new(0, 1);
        for samples in [16, 20, 128, 132, 1000] {
            let mut sum = 0.0;
            let mut degrees = 0.0;
            for _ in 0..400 {
                let scatter = of(8..8 + samples, &mut rng).scatter().expect("there are enough");
                (sum, degrees) = (sum + scatter.of_sum, scatter.degrees);
            }
            // Two channels of variance 1/12; what is left out makes no difference beyond its share.
            let ratio = sum / 400.0 * samples as f64 * 6.0;
            let deviation = (2.0 / (2.0 * 400.0 * degrees)).sqrt();
            assert!((ratio - 1.0).abs() < 4.0 * deviation + 0.1, "{samples}: {ratio}");
        }
    }

    #[test]
    fn batches_are_few_and_complete_or_left_out() {
        let degrees = |samples| of(0..samples, &mut Pcg32::new(0, 1)).scatter().map(|s| s.degrees);
        let expected = [(12, None), (15, None), (16, Some(3.0)), (128, Some(31.0)), (129, Some(15.0))];
        assert_eq!(expected.map(|(samples, _)| degrees(samples)), expected.map(|(_, degrees)| degrees));
        assert!((15.0..32.0).contains(&degrees(100_000).expect("there are enough")));
    }
}
