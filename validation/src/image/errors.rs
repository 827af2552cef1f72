//! Error metrics as in publications, with `a` as the reference.

use serde::Serialize;

use super::pair::Pair;
use super::similarity::similarity;
use crate::relative_error::{SOFTENING, trimmed_mean};

/// Errors of b against a over pixels where both are finite. All are means over pixels.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    /// b − a.
    pub bias: f64,
    /// (b − a)².
    pub mse: f64,
    /// Expectation of `mse` if both images have the same expectation: the sum of both variances. NaN where
    /// unknown.
    pub expected_mse: f64,
    /// (b − a)² / (a² + (0.01 mean a)²).
    pub relative_mse: f64,
    /// `relative_mse` without the largest 0.1 % of squared errors.
    pub relative_mse_trimmed: f64,
    /// |b − a| / (|a| + 0.01 mean |a|).
    pub mape: f64,
    /// The mean structural similarity (Wang et al. 2004) of v/(|v| + mean |a|); 1 for equal images.
    pub ssim: f64,
}

pub(super) fn errors(pair: &Pair) -> Errors {
    let pixels = || pair.pixels().map(|(_, _, pixel)| pixel).filter(|pixel| pixel.difference().is_finite());
    let count = pixels().count() as f64;
    let mean = |term: &dyn Fn(super::pair::Pixel) -> f64| pixels().map(term).sum::<f64>() / count;
    let soft = SOFTENING * mean(&|pixel| pixel.a.abs());
    // An exact match has no error, even where the reference is black everywhere and the quotient would be
    // 0/0.
    let quotient = |error: f64, scale: f64| if error == 0.0 { 0.0 } else { error / scale };
    let square = |value: f64| value * value;
    let relative =
        |pixel: super::pair::Pixel| quotient(square(pixel.difference()), square(pixel.a) + square(soft));
    let variance = mean(&|pixel| pixel.variance());
    Errors {
        bias: mean(&|pixel| pixel.difference()),
        mse: mean(&|pixel| square(pixel.difference())),
        expected_mse: if variance.is_finite() { variance } else { f64::NAN },
        relative_mse: mean(&relative),
        relative_mse_trimmed: trimmed_mean(pixels().map(relative).collect()),
        mape: mean(&|pixel| quotient(pixel.difference().abs(), pixel.a.abs() + soft)),
        ssim: similarity(pair),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::grey;

    #[test]
    fn metrics_follow_their_formulae_and_scale() {
        let a = grey(2, &[1.0, 3.0], 0.25);
        let b = grey(2, &[2.0, 3.0], 0.25);
        let (pairs, _) = Pair::all(&a, &b);
        let found = errors(&pairs[0]);
        assert_eq!((found.bias, found.mse, found.expected_mse), (0.5, 0.5, 0.5));
        assert!((found.relative_mse - 0.5 / (1.0 + 0.0004)).abs() < 1e-12);
        assert!((found.mape - 0.5 / 1.02).abs() < 1e-12);
        // The trimmed mean leaves out at least one pixel: the wrong one.
        assert_eq!(found.relative_mse_trimmed, 0.0);
        let (a, b) = (grey(2, &[1e-20, 3e-20], 0.0), grey(2, &[2e-20, 3e-20], 0.0));
        let (pairs, _) = Pair::all(&a, &b);
        assert!((errors(&pairs[0]).relative_mse / found.relative_mse - 1.0).abs() < 1e-9);
    }

    #[test]
    fn fireflies_move_the_mean_but_not_the_trimmed_mean() {
        let a = grey(100, &[1.0; 10_000], 0.0);
        let mut b = a.clone();
        for index in 0..10 {
            b.channels[0].mean[index * 977] = 1000.0;
        }
        let (pairs, _) = Pair::all(&a, &b);
        let found = errors(&pairs[0]);
        assert!(found.relative_mse > 900.0 && found.relative_mse_trimmed == 0.0);
    }
}
