//! The error of a picture against the mean of other pictures of the same renderer.
//!
//! With a reference m̂ = m + e of variance σ²_m in a value, E (x − m̂)² = MSE(x) + σ²_m as long as x is
//! independent of m̂; so σ²_m, estimated from the variance of the reference's own pictures, is subtracted
//! value by value. relMSE divides by m̂² + ε² with ε one per cent of the picture's mean, the same for every
//! picture of a renderer.

use crate::relative_error::{SOFTENING, trimmed_mean};
use serde::{Deserialize, Serialize};

/// A picture: all channels of all pixels in a fixed order.
pub type Picture = Vec<f64>;

/// The mean of pictures and the variance of that mean, value by value.
pub struct Reference {
    pub mean: Picture,
    pub variance: Picture,
}

/// Errors of a picture, relative to the reference's values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Mean relative squared error of all values, the reference's variance subtracted.
    pub relative_mse: f64,
    /// The same mean without the 0.1 % of values with the largest errors.
    pub trimmed: f64,
    /// Median relative squared error; the reference's variance is not subtracted.
    pub median: f64,
    /// Mean squared error, in the square of the pictures' unit.
    pub mse: f64,
    /// The mean of all values over the reference's mean.
    pub brightness: f64,
}

/// The mean of at least two pictures of one size, and its variance; `None` otherwise.
pub fn reference(pictures: &[Picture]) -> Option<Reference> {
    let first = pictures.first().filter(|_| pictures.len() > 1)?;
    if pictures.iter().any(|p| p.len() != first.len()) {
        return None;
    }
    let count = pictures.len() as f64;
    let mean: Picture =
        (0..first.len()).map(|i| pictures.iter().map(|p| p[i]).sum::<f64>() / count).collect();
    let variance = mean.iter().enumerate().map(|(i, m)| {
        let squares: f64 = pictures.iter().map(|p| (p[i] - m) * (p[i] - m)).sum();
        squares / (count * (count - 1.0))
    });
    Some(Reference { variance: variance.collect(), mean })
}

/// For each picture the mean of the others, with its variance; none if they are fewer than three.
pub fn without_each(pictures: &[Picture]) -> Vec<Reference> {
    let others = |left: usize| {
        let others = pictures.iter().enumerate().filter(|(k, _)| *k != left);
        reference(&others.map(|(_, picture)| picture.clone()).collect::<Vec<_>>())
    };
    (0..pictures.len()).filter_map(others).collect()
}

/// The errors of a picture that is independent of the reference; `None` unless it is of the same size.
pub fn errors(picture: &Picture, reference: &Reference) -> Option<Errors> {
    if picture.is_empty() || picture.len() != reference.mean.len() {
        return None;
    }
    let count = picture.len() as f64;
    let dark = reference.dark();
    let values = || picture.iter().zip(&reference.mean).zip(&reference.variance);
    let square = |x: &f64, m: &f64| (x - m) * (x - m);
    let relative: Vec<f64> =
        values().map(|((x, m), variance)| (square(x, m) - variance) / (m * m + dark)).collect();
    let mut plain = relative_squares(picture, reference);
    plain.sort_by(f64::total_cmp);
    Some(Errors {
        relative_mse: relative.iter().sum::<f64>() / count,
        trimmed: trimmed_mean(relative),
        median: plain[plain.len() / 2],
        mse: values().map(|((x, m), variance)| square(x, m) - variance).sum::<f64>() / count,
        brightness: picture.iter().sum::<f64>() / reference.mean.iter().sum::<f64>(),
    })
}

/// Relative squared differences from the reference, value by value; the reference's variance is not
/// subtracted.
pub fn relative_squares(picture: &Picture, reference: &Reference) -> Vec<f64> {
    let dark = reference.dark();
    picture.iter().zip(&reference.mean).map(|(x, m)| (x - m) * (x - m) / (m * m + dark)).collect()
}

impl Reference {
    /// ε², which is added to the squares of the reference's values in denominators.
    fn dark(&self) -> f64 {
        let dark = SOFTENING * self.mean.iter().sum::<f64>() / self.mean.len() as f64;
        dark * dark
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Stream;

    #[test]
    fn the_references_own_noise_is_taken_out() {
        let mut stream = Stream::named("reference noise", 0);
        let mut noisy =
            |deviation: f64| -> Picture { (0..40_000).map(|_| 2.0 + deviation * stream.normal()).collect() };
        // The reference is as noisy as the picture: without the subtraction the error would be twice as
        // large.
        let pictures: Vec<Picture> = (0..4).map(|_| noisy(0.2)).collect();
        let found = errors(&noisy(0.1), &reference(&pictures).unwrap()).unwrap();
        // The squared error is 0.01; its standard error is 0.01 · 2 · √(2/40000) = 1.4e-4.
        assert!((found.mse - 0.01).abs() < 5e-4, "{found:?}");
        assert!((found.relative_mse - 0.01 / 4.0004).abs() < 2e-4, "{found:?}");
    }

    #[test]
    fn trimming_leaves_a_firefly_out() {
        let flat = vec![1.0; 2000];
        let pictures = vec![flat.clone(), flat.clone()];
        let mut spoiled = flat;
        spoiled[7] = 1001.0;
        let found = errors(&spoiled, &reference(&pictures).unwrap()).unwrap();
        assert_eq!((found.trimmed, found.median), (0.0, 0.0));
        assert!((found.mse - 500.0).abs() < 1e-9);
    }

    #[test]
    fn a_picture_that_misses_light_is_darker_and_wrong() {
        let flat = vec![2.0; 2000];
        let reference = reference(&[flat.clone(), flat]).unwrap();
        let found = errors(&vec![1.5; 2000], &reference).unwrap();
        assert_eq!((found.brightness, found.mse), (0.75, 0.25));
        assert!(errors(&vec![1.5; 1999], &reference).is_none());
    }

    #[test]
    fn each_picture_is_left_out_once() {
        let pictures = [vec![1.0, 4.0], vec![2.0, 4.0], vec![6.0, 4.0]];
        let means: Vec<Picture> = without_each(&pictures).into_iter().map(|of| of.mean).collect();
        assert_eq!(means, [vec![4.0, 4.0], vec![3.5, 4.0], vec![1.5, 4.0]]);
        assert!(without_each(&pictures[..2]).is_empty());
    }

    #[test]
    fn one_picture_is_no_reference() {
        assert!(reference(&[vec![1.0]]).is_none() && reference(&[vec![1.0], vec![1.0, 2.0]]).is_none());
    }
}
