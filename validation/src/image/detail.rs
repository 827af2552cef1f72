//! Detail level: differences that leave the means of tiles as they are, such as a picture that is shifted by
//! a pixel, a texture filtered wrongly, or a pixel that is stuck.
//!
//! Squared differences of pixels less their variances are zero in expectation where both images expect the
//! same. Nothing is divided by the variance of a pixel, which few samples estimate badly; and each variance
//! is raised to what the other image predicts (see [`tiles`](super::tiles)), so that the sum errs towards no
//! difference. Its standard error is that of the scatter between groups of pixels.
//!
//! One pixel among thousands shows in no sum. It is different if it is so by twice as many standard errors as
//! the corrected level asks of Student's distribution, where no variance counts for less than the mean of its
//! neighbourhood's. That distribution's degrees of freedom are those with which the variances of the neighbourhood
//! scatter as they do (Satterthwaite 1946): few where they come from few samples, and where some pixels meet what
//! others miss.

use serde::Serialize;

use super::pair::{Pair, Pixel, Place};
use crate::statistics::{
    Estimate,
    distributions::{normal_two_sided, student_quantile, student_two_sided},
    multiplicity::smallest_of,
};

/// Fewest groups of pixels between which there is scatter.
const GROUPS: usize = 16;

/// The comparison of one channel, finer than tiles.
#[derive(Clone, Debug, Serialize)]
pub struct DetailComparison {
    /// Root of the mean square of the differences of pixels that their noise does not explain, relative to
    /// the image's mean; 0 if it explains all.
    pub rms: f64,
    /// What that is below, at the level of the settings; NaN where nothing is known.
    pub rms_bound: f64,
    /// p-value of "noise explains all".
    pub p_value: f64,
    /// The pixel that differs most, and by how many standard errors.
    pub worst: Option<(Place, f64)>,
    /// p-value of "noise explains that pixel", corrected for the number of pixels.
    pub worst_p_value: f64,
    /// Whether the differences of pixels, or that of the worst, are significant and beyond the margin.
    pub different: bool,
    /// Whether it is the worst pixel alone that is.
    pub single: bool,
}

/// Levels and the margin, relative to the image's mean.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Of the interval.
    pub level: f64,
    /// Of each of the two tests, corrected for all others.
    pub corrected: f64,
    pub margin: f64,
    /// Pixels along a tile's side.
    pub tile_size: usize,
}

/// A group of neighbouring pixels: their number, and the sums of squared differences less variances, of
/// variances, and of their squares.
#[derive(Clone, Copy, Default)]
struct Group {
    count: f64,
    excess: f64,
    variance: f64,
    squares: f64,
}

impl Group {
    fn mean_variance(&self) -> f64 {
        self.variance / self.count
    }

    /// The degrees of freedom d of the variances: those of χ² with d degrees scatter by 2/d of their squared mean.
    fn degrees(&self) -> f64 {
        let mean = self.mean_variance();
        2.0 * mean * mean / (self.squares / self.count - mean * mean)
    }
}

/// b being typically `ratio` times as noisy as a.
pub(super) fn compare(pair: &Pair, ratio: Option<f64>, limits: Limits) -> DetailComparison {
    let informed =
        || pair.pixels().filter(|(_, _, p)| p.is_testable()).map(|(x, y, p)| (x, y, p.informed(ratio)));
    let side = side(pair, limits.tile_size);
    let columns = pair.width.div_ceil(side);
    let group_of = |x: usize, y: usize| y / side * columns + x / side;
    let mut groups = vec![Group::default(); columns * pair.height.div_ceil(side)];
    let (mut count, mut sum) = (0.0, 0.0);
    for (x, y, pixel) in informed() {
        let group = &mut groups[group_of(x, y)];
        group.count += 1.0;
        group.excess += pixel.difference() * pixel.difference() - pixel.variance();
        group.variance += pixel.variance();
        group.squares += pixel.variance() * pixel.variance();
        (count, sum) = (count + 1.0, sum + pixel.a + pixel.b);
    }
    let scale = 0.5 * sum.abs() / count;
    let mut found = whole(&groups, scale, limits);

    let score = |pixel: Pixel, group: Group| {
        let variance = pixel.variance().max(group.mean_variance());
        if variance > 0.0 { pixel.difference() / variance.sqrt() } else { 0.0 }
    };
    let scored = informed().map(|(x, y, pixel)| (x, y, pixel, score(pixel, groups[group_of(x, y)])));
    if let Some((x, y, pixel, z)) = scored.max_by(|a, b| a.3.abs().total_cmp(&b.3.abs())) {
        found.worst = Some((pair.place(x, y), z));
        let degrees = groups[group_of(x, y)].degrees();
        found.worst_p_value = smallest_of(of_one(0.5 * z, degrees), count as usize);
        let beyond = pixel.difference().abs() > limits.margin * scale;
        found.single = !found.different && found.worst_p_value <= limits.corrected && beyond;
        found.different |= found.single;
    }
    found
}

/// Student's p-value, or that of normal noise where variances do not scatter.
fn of_one(t: f64, degrees: f64) -> f64 {
    if degrees > 0.0 && degrees.is_finite() { student_two_sided(t, degrees) } else { normal_two_sided(t) }
}

/// The side of groups that are many, and no larger than tiles.
fn side(pair: &Pair, tile_size: usize) -> usize {
    let many = |side: &usize| pair.width.div_ceil(*side) * pair.height.div_ceil(*side) >= GROUPS;
    std::iter::successors(Some(tile_size.max(1)), |side| (*side > 1).then_some(side / 2))
        .find(many)
        .unwrap_or(1)
}

/// What all pixels say together.
fn whole(groups: &[Group], scale: f64, limits: Limits) -> DetailComparison {
    let groups: Vec<&Group> = groups.iter().filter(|group| group.count > 0.0).collect();
    let mut found = DetailComparison {
        rms: f64::NAN,
        rms_bound: f64::NAN,
        p_value: 1.0,
        worst: None,
        worst_p_value: 1.0,
        different: false,
        single: false,
    };
    if groups.len() < 2 {
        return found;
    }
    let estimate = Estimate::of(groups.iter().map(|group| group.excess / group.count));
    let error = estimate.variance.sqrt();
    let t = if estimate.mean == 0.0 { 0.0 } else { estimate.mean / error };
    let two_sided = student_two_sided(t, estimate.degrees);
    // One that is less than noise explains is no difference.
    found.p_value = if t > 0.0 { 0.5 * two_sided } else { 1.0 - 0.5 * two_sided };
    let relative = |square: f64| square.max(0.0).sqrt() / scale;
    found.rms = relative(estimate.mean);
    found.rms_bound =
        relative(estimate.mean + student_quantile(2.0 * limits.level, estimate.degrees) * error);
    found.different = found.p_value <= limits.corrected && found.rms > limits.margin;
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::{Noise, grey, render};
    use crate::image::tiles::noise_ratio_of;

    const LIMITS: Limits = Limits { level: 0.01, corrected: 0.001, margin: 0.02, tile_size: 16 };

    fn compared(a: &crate::image::Image, b: &crate::image::Image) -> DetailComparison {
        let pair = &Pair::all(a, b).0[0];
        compare(pair, noise_ratio_of(pair, LIMITS.tile_size), LIMITS)
    }

    #[test]
    fn a_picture_that_is_shifted_by_a_pixel_is_different() {
        let checks = |shift: usize| -> Vec<f64> {
            (0..64 * 64).map(|i| 0.5 + ((i % 64 + i / 64 + shift) % 2) as f64).collect()
        };
        let image = |shift, name| render(64, &checks(shift), Noise::Normal, 64, name, 0);
        let found = compared(&image(0, "checks a"), &image(1, "checks b"));
        // Every pixel is off by 1, of a mean of 1.
        assert!(found.different && !found.single && (found.rms - 1.0).abs() < 0.05, "{found:?}");
        let same = compared(&image(0, "checks a"), &image(0, "checks c"));
        assert!(!same.different && same.rms_bound < 0.2, "{same:?}");
    }

    #[test]
    fn one_pixel_that_is_stuck_is_found_and_named() {
        let image = |name| render(64, &[1.0; 64 * 64], Noise::Exponential, 64, name, 0);
        let (a, mut b) = (image("stuck a"), image("stuck b"));
        assert!(!compared(&a, &b).different);
        b.channels[0].mean[64 * 3 + 7] = 4.0;
        let found = compared(&a, &b);
        let place = found.worst.as_ref().map(|(place, _)| (place.x, place.y));
        assert!(found.different && found.single && place == Some((7, 3)), "{found:?}");
    }

    #[test]
    fn variances_of_two_samples_each_raise_no_alarm() {
        for noise in [Noise::Normal, Noise::Exponential, Noise::Firefly] {
            let different = |trial: u64| {
                let image = |name| render(32, &[1.0; 32 * 32], noise, 2, name, trial);
                compared(&image("two a"), &image("two b")).different
            };
            let share = (0..200).filter(|&trial| different(trial)).count();
            // At the level of 0.1 % for each of two tests, five of 200 are one in ten thousand.
            assert!(share < 5, "{noise:?} {share}");
        }
    }

    /// Two values that both met a rare event have no variance of their own, and are many times as large as others.
    #[test]
    fn events_that_both_of_two_samples_met_are_no_alarm() {
        let different = |trial: u64| {
            let image = |name| render(128, &[1.0; 128 * 128], Noise::Edge, 2, name, trial);
            compared(&image("met a"), &image("met b")).single
        };
        assert_eq!((0..20).filter(|&trial| different(trial)).count(), 0);
    }

    #[test]
    fn without_noise_or_with_one_pixel_there_is_nothing_to_say() {
        let found = compared(&grey(1, &[1.0], 0.01), &grey(1, &[1.0], 0.01));
        assert!(!found.different && found.rms.is_nan());
        let exact = grey(8, &[1.0; 64], 0.0);
        let found = compared(&exact, &exact.clone());
        assert!(!found.different && found.rms == 0.0 && found.rms_bound == 0.0, "{found:?}");
    }
}
