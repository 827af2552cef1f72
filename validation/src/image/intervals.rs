//! Intervals that hold what pixels expect.
//!
//! A pixel that has met no rare light does not know that there is any, and no function of its own samples can
//! tell: on scenes with caustics and small lamps 95 % intervals from pixels' own variances hold two thirds to
//! nine tenths of the expectations. Its neighbours know. So the variance V of a pixel counts for no less than
//! the mean V̄ of those within two pixels, and
//!
//!   h = t √max(V, V̄)
//!
//! is half the width of its interval, where t is the quantile of Student's distribution with the degrees of
//! freedom of V (Student 1908). V̄ has more of them, so the interval errs on the wide side.

use crate::statistics::distributions::student_quantile;

/// How far away neighbours are, along rows and columns.
const REACH: usize = 2;

/// Half the width of each pixel's interval, in the unit of its value: [value − h, value + h] holds the
/// expectation with probability `confidence` if noise is normal with variances alike among neighbours. Infinite where
/// the pixel's variance is; neighbours without a finite variance do not count.
///
/// `variances` are those of the pixels' means, in rows of `width`; `degrees` their degrees of freedom, one less than
/// the number of independent values that each is estimated from, or infinity where they are exact.
pub fn half_widths(width: usize, variances: &[f64], degrees: f64, confidence: f64) -> Vec<f64> {
    let quantile = student_quantile(1.0 - confidence, degrees);
    let variance = |(pixel, &own): (usize, &f64)| {
        let around = of_neighbourhood(width, variances, pixel);
        // Not `max`, which would drop a NaN.
        if own < around { around } else { own }
    };
    variances.iter().enumerate().map(|of| quantile * variance(of).sqrt()).collect()
}

/// The mean of the finite variances within reach of a pixel; 0 if there is none.
fn of_neighbourhood(width: usize, variances: &[f64], pixel: usize) -> f64 {
    let (x, y) = (pixel % width, pixel / width);
    let last = |at: usize, count: usize| (at + REACH).min(count - 1);
    let (mut sum, mut count) = (0.0, 0.0);
    for row in y.saturating_sub(REACH)..=last(y, variances.len() / width) {
        let from = row * width;
        for variance in &variances[from + x.saturating_sub(REACH)..=from + last(x, width)] {
            if variance.is_finite() {
                (sum, count) = (sum + variance, count + 1.0);
            }
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::{Noise, render};

    /// The share of pixels whose own interval holds the expectation, and of those whose interval here does.
    fn coverage(noise: Noise, samples: usize) -> [f64; 2] {
        let scene = [1.0; 64 * 64];
        let image = render(64, &scene, noise, samples, "coverage of intervals", 0);
        let (channel, degrees) = (&image.channels[0], (samples - 1) as f64);
        let variances = channel.variance.as_ref().unwrap();
        let own: Vec<f64> = variances.iter().map(|v| student_quantile(0.05, degrees) * v.sqrt()).collect();
        [own, half_widths(64, variances, degrees, 0.95)].map(|widths| {
            let held =
                channel.mean.iter().zip(&widths).filter(|(mean, width)| (**mean - 1.0).abs() <= **width);
            held.count() as f64 / scene.len() as f64
        })
    }

    #[test]
    fn normal_noise_is_held() {
        let [own, smoothed] = coverage(Noise::Normal, 8);
        // The standard error of a share of 4096 pixels is 0.34 %.
        assert!((own - 0.95).abs() < 0.015 && (0.95..0.99).contains(&smoothed), "{own} {smoothed}");
    }

    #[test]
    fn rare_light_that_neighbours_have_met_is_held() {
        let [own, smoothed] = coverage(Noise::Firefly, 16);
        // Two pixels of three have not met it: 0.975¹⁶.
        assert!(own < 0.4 && smoothed > 0.94, "{own} {smoothed}");
    }

    #[test]
    fn neighbours_count_up_to_the_borders() {
        let mut variances = vec![0.0; 5 * 4];
        variances[0] = 9.0;
        let found = half_widths(5, &variances, f64::INFINITY, 0.95);
        // Nine pixels are within reach of a corner, 12 of its neighbour, 20 of one two pixels from either border.
        let expected = [9.0, 9.0 / 12.0, 9.0 / 15.0, 0.0, 0.0];
        for (width, variance) in found.iter().zip(expected) {
            assert!((width - 1.959_963_984_540_054 * f64::sqrt(variance)).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn what_is_unknown_stays_so_and_does_not_spread() {
        let found = half_widths(3, &[f64::INFINITY, 4.0, f64::NAN], 3.0, 0.95);
        assert!(found[0].is_infinite() && found[1].is_finite() && found[2].is_nan(), "{found:?}");
        assert!(half_widths(1, &[f64::INFINITY], 3.0, 0.95)[0].is_infinite());
    }
}
