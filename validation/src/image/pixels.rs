//! Pixel level: an indication that does not decide, for the following reason.
//!
//! A pixel's mean is far from normal in the tail that a correction for 10⁶ tests requires, and its own
//! variance does not include what it missed: with 16 exponential samples against a reference of 1024, 0.5 %
//! of the pixels of a correct image lie beyond 5 standard errors (8,000 times the normal share), with a light
//! hit once in 40 samples, 64 against 1024, 11 %. So each image's variance is raised to what the other image
//! predicts; then none of 400,000 such pixels lay beyond 5, and the share with p < 1 % stayed below 0.4 %.
//! That is safe but conservative, to a degree that depends on the noise, and therefore no part of the
//! verdict: the share is called suspicious above 1 % plus three standard errors.

use serde::Serialize;

use super::correlation::Correlation;
use super::pair::{Pair, Pixel, Place};
use crate::statistics::distributions::{chi_square_upper, normal_two_sided};

/// Bins of the histogram of p-values.
const BINS: usize = 20;

/// Statistics of the z-scores of one channel's pixels, of those with noise only.
#[derive(Clone, Debug, Serialize)]
pub struct PixelFigures {
    /// Number of pixels with noise and known variances.
    pub tested: usize,
    /// Number of p-values in each twentieth of \[0, 1\]; uniform if the noise is normal and the images agree.
    pub histogram: Vec<usize>,
    /// p-value of a χ² test of the histogram's uniformity. Only an indication: heavy tails make it small for
    /// correct images too.
    pub evenness: f64,
    /// Share of pixels with p < 1 %.
    pub share_beyond: f64,
    /// Whether `share_beyond` exceeds 1 % by three standard errors.
    pub suspicious: bool,
    /// The largest |z|.
    pub worst_z: f64,
    /// The pixel of `worst_z`.
    pub worst: Option<Place>,
    /// Correlation of the z-scores of neighbours in rows and columns, within tiles. A value far from 0 (in units of
    /// 1/√n) means that pixels share samples; or that the images differ in connected regions.
    pub neighbour_correlation: f64,
    /// How many times the variance of a tile's mean is that of independent pixels, by that correlation; 1 if it is
    /// not significant. Means and tiles are judged by variances so much larger.
    pub shared_noise: f64,
}

/// b being typically `ratio` times as noisy as a.
pub(super) fn figures(pair: &Pair, ratio: Option<f64>) -> PixelFigures {
    let mut histogram = vec![0; BINS];
    let (mut beyond, mut worst_z, mut worst) = (0, 0.0f64, None);
    for (x, y, z) in scores(pair, ratio) {
        let p_value = normal_two_sided(z);
        histogram[((p_value * BINS as f64) as usize).min(BINS - 1)] += 1;
        beyond += usize::from(p_value < 0.01);
        if z.abs() > worst_z.abs() {
            (worst_z, worst) = (z, Some(pair.place(x, y)));
        }
    }
    let tested: usize = histogram.iter().sum();
    let expected = tested as f64 / BINS as f64;
    let statistic: f64 =
        histogram.iter().map(|&count| (count as f64 - expected) * (count as f64 - expected)).sum();
    let limit = 0.01 * tested as f64;
    let correlation = Correlation::of(pair, ratio);
    PixelFigures {
        tested,
        evenness: if tested == 0 { 1.0 } else { chi_square_upper(statistic / expected, (BINS - 1) as f64) },
        share_beyond: beyond as f64 / tested.max(1) as f64,
        suspicious: beyond as f64 > limit + 3.0 * limit.sqrt(),
        histogram,
        worst_z,
        worst,
        neighbour_correlation: correlation.of_neighbours(),
        shared_noise: correlation.shared_noise(),
    }
}

/// The z-score of a pixel; `None` without noise.
pub(super) fn score(pixel: Pixel, ratio: Option<f64>) -> Option<f64> {
    let noisy = pixel.is_testable() && pixel.variance() > 0.0;
    noisy.then(|| pixel.informed(ratio).z())
}

fn scores(pair: &Pair, ratio: Option<f64>) -> impl Iterator<Item = (usize, usize, f64)> {
    pair.pixels().filter_map(move |(x, y, pixel)| score(pixel, ratio).map(|z| (x, y, z)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::{Noise, grey, render};
    use crate::image::tiles::noise_ratio_of;

    #[test]
    fn honest_noise_is_not_suspicious_and_neighbours_are_unrelated() {
        for noise in [Noise::Normal, Noise::Exponential, Noise::Firefly] {
            for samples in [[64, 64], [256, 16]] {
                let scene = vec![1.0; 64 * 64];
                let a = render(64, &scene, noise, samples[0], "pixels a", 0);
                let b = render(64, &scene, noise, samples[1], "pixels b", 0);
                let (pairs, _) = Pair::all(&a, &b);
                let found = figures(&pairs[0], noise_ratio_of(&pairs[0], 16));
                assert!(!found.suspicious, "{noise:?} {samples:?} {}", found.share_beyond);
                assert!(
                    found.neighbour_correlation.abs() < 4.0 / 64.0 && found.shared_noise == 1.0,
                    "{}",
                    found.neighbour_correlation
                );
                assert!(found.worst_z.abs() < 5.0, "{noise:?} {samples:?} {}", found.worst_z);
            }
        }
    }

    #[test]
    fn a_salted_image_is_suspicious_and_the_worst_pixel_is_named() {
        let a = grey(64, &[1.0; 64 * 64], 0.01);
        let mut b = a.clone();
        for index in (0..64 * 64).step_by(20) {
            b.channels[0].mean[index] = 1.6;
        }
        b.channels[0].mean[64 * 3 + 7] = 2.5;
        let (pairs, _) = Pair::all(&a, &b);
        let found = figures(&pairs[0], noise_ratio_of(&pairs[0], 16));
        assert!(found.suspicious);
        assert_eq!(found.worst, Some(pairs[0].place(7, 3)));
    }
}
