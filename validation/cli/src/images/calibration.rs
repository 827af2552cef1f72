//! The calibration of the image comparison on real renders.
//!
//! Two properties are tested. *Level*: pairs of renders of the same scene that differ in their seed only are
//! called different as often as the level states. *Power*: a loss of 2 % in the noisier half of an image is
//! detected, at the sample budget of Mitsuba's own image tests (two million per picture, `test_renders.py`).

use crate::provenance::Provenance;
use crate::references::{Reference, folder, references};
use serde::Serialize;
use validation::Verdict;
use validation::image::{Image, Settings, compare};
use validation::statistics::binomial::binomial_two_sided;

/// The effort of the calibration.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Number of pairs of correct images, over all scenes.
    pub pairs: usize,
    /// Samples per pixel of these pairs.
    pub samples: u32,
    /// Renders of a scene at Mitsuba's budget; each is compared with a damaged copy of every other.
    pub renders: u64,
}

/// The default effort.
pub const EFFORT: Effort = Effort { pairs: 1000, samples: 64, renders: 12 };

/// Samples of an image in Mitsuba's tests.
const BUDGET: u32 = 2_000_000;

/// The share of light that is left in the damaged half.
const KEPT: f64 = 0.98;

/// Smallest and largest share of correct pairs that may be rejected.
const REJECTED: [f64; 2] = [0.003, 0.021];
/// Power that a scene must reach.
const POWER: f64 = 0.9;
/// Share of scenes that must reach it.
const SCENES: f64 = 0.85;

/// The results of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub scene: String,
    /// Number of pairs of correct images.
    pub pairs: usize,
    /// Number of those pairs that were called different.
    pub rejected: usize,
    /// Samples per pixel at Mitsuba's budget.
    pub samples: u32,
    /// Share of damaged pairs that were called different.
    pub power: f64,
    /// The relative standard error of the mean over the damaged half, in the channel where it is smallest;
    /// the loss of 2 % must be detected against it.
    pub standard_error: f64,
}

/// The result of the calibration, as a document to be committed.
#[derive(Clone, Debug, Serialize)]
pub struct Calibration {
    #[serde(flatten)]
    made: Provenance,
    pub verdict: Verdict,
    pub message: String,
    level: f64,
    margin: f64,
    samples_of_pairs: u32,
    pub rows: Vec<Row>,
}

/// Calibrates on all reference scenes in RGB; `tell` gets the results of each.
pub fn calibrate(effort: &Effort, mut tell: impl FnMut(&Row)) -> Result<Calibration, String> {
    // Recorded at the start, since sources may change while it renders.
    let made = Provenance::here();
    let mut scenes: Vec<Reference> = references(&folder())?;
    // Scenes without light cannot lose any.
    scenes.retain(|scene| scene.name.ends_with("::rgb") && !scene.name.starts_with("depth"));
    let settings = Settings::default();
    let mut rows = vec![];
    for (i, scene) in scenes.iter().enumerate() {
        let share = |i: usize| i * effort.pairs / scenes.len();
        let row = row(scene, share(i + 1) - share(i), effort, &settings)?;
        tell(&row);
        rows.push(row);
    }
    let (verdict, message) = conclude(&rows);
    let (level, margin) = (settings.level, settings.margin);
    Ok(Calibration { made, verdict, message, level, margin, samples_of_pairs: effort.samples, rows })
}

fn row(scene: &Reference, pairs: usize, effort: &Effort, settings: &Settings) -> Result<Row, String> {
    let different = |a: &Image, b: &Image| {
        let found = compare(a, b, settings).map_err(|e| e.to_string())?;
        Ok::<usize, String>(usize::from(found.verdict == Verdict::Different))
    };
    let mut rejected = 0;
    for pair in 0..pairs as u64 {
        let image = |number: u64| colors(scene.render(effort.samples, number)?);
        rejected += different(&image(2 * pair)?, &image(2 * pair + 1)?)?;
    }
    let size = colors(scene.render(1, 0)?)?;
    let samples = BUDGET / (size.width * size.height).max(1) as u32;
    // Seeds that no correct pair has used.
    let first = 2 * pairs as u64;
    let images = (0..effort.renders).map(|i| colors(scene.render(samples, first + i)?));
    let images = images.collect::<Result<Vec<Image>, String>>()?;
    let noisy = images.first().map(noisier_half).unwrap_or_default();
    let damaged: Vec<Image> = images.iter().map(|image| dimmed(image, &noisy)).collect();
    let (mut found, mut asked) = (0, 0);
    for (i, a) in images.iter().enumerate() {
        for (_, b) in damaged.iter().enumerate().filter(|(j, _)| *j != i) {
            found += different(a, b)?;
            asked += 1;
        }
    }
    Ok(Row {
        scene: scene.name.clone(),
        pairs,
        rejected,
        samples,
        power: found as f64 / asked.max(1) as f64,
        standard_error: images.first().map_or(f64::NAN, |image| relative_error(image, &noisy)),
    })
}

/// The image with the colour channels only: positions and depths do not change with the light.
fn colors(mut image: Image) -> Result<Image, String> {
    image.channels.retain(|channel| ["R", "G", "B"].contains(&channel.name.as_str()));
    if image.channels.is_empty() { Err("the image has no colours".into()) } else { Ok(image) }
}

/// Which half of the pixels has the larger variance, all channels together.
fn noisier_half(image: &Image) -> Vec<bool> {
    let variance = |pixel: usize| -> f64 {
        image.channels.iter().filter_map(|channel| Some(channel.variance.as_ref()?[pixel])).sum()
    };
    let all: Vec<f64> = (0..image.width * image.height).map(variance).collect();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&i, &j| all[i].total_cmp(&all[j]));
    let mut noisy = vec![false; all.len()];
    order[all.len() / 2..].iter().for_each(|&i| noisy[i] = true);
    noisy
}

/// The image with the chosen pixels darkened.
fn dimmed(image: &Image, chosen: &[bool]) -> Image {
    let mut image = image.clone();
    for channel in &mut image.channels {
        let values = channel.mean.iter_mut().zip(chosen).filter(|(_, chosen)| **chosen);
        values.for_each(|(value, _)| *value *= KEPT);
        let variances = channel.variance.iter_mut().flatten().zip(chosen).filter(|(_, chosen)| **chosen);
        variances.for_each(|(variance, _)| *variance *= KEPT * KEPT);
    }
    image
}

/// The relative standard error of the mean over the chosen pixels, in the channel where it is smallest.
fn relative_error(image: &Image, chosen: &[bool]) -> f64 {
    let sum = |values: &[f64]| -> f64 {
        values.iter().zip(chosen).filter(|(_, chosen)| **chosen).map(|(value, _)| value).sum()
    };
    let errors = image.channels.iter().filter_map(|c| Some(sum(c.variance.as_ref()?).sqrt() / sum(&c.mean)));
    errors.fold(f64::INFINITY, f64::min)
}

fn conclude(rows: &[Row]) -> (Verdict, String) {
    let sum = |count: fn(&Row) -> usize| rows.iter().map(count).sum::<usize>();
    let (pairs, rejected) = (sum(|row| row.pairs), sum(|row| row.rejected));
    let share = rejected as f64 / pairs.max(1) as f64;
    let strong = rows.iter().filter(|row| row.power >= POWER).count();
    let of_scenes = strong as f64 / rows.len().max(1) as f64;
    let calibrated = (REJECTED[0]..=REJECTED[1]).contains(&share);
    let message = format!(
        "{rejected} of {pairs} honest pairs rejected at level 0.01 (p = {:.3}); a loss of 2 % in the noisier half found \
         with {:.0} % power on {strong} of {} scenes",
        binomial_two_sided(rejected as u64, pairs as u64, 0.01),
        100.0 * POWER,
        rows.len()
    );
    let holds = calibrated && of_scenes >= SCENES && rows.len() >= 20;
    (if holds { Verdict::Equivalent } else { Verdict::Different }, message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::image::Channel;

    fn image(mean: Vec<f64>, variance: Vec<f64>) -> Image {
        let channel = Channel { name: "G".into(), mean, variance: Some(variance) };
        Image { width: 2, height: 2, channels: vec![channel] }
    }

    #[test]
    fn the_noisier_half_is_dimmed() {
        let image = image(vec![1.0, 2.0, 3.0, 4.0], vec![0.4, 0.1, 0.3, 0.2]);
        let noisy = noisier_half(&image);
        assert_eq!(noisy, [true, false, true, false]);
        let dimmed = dimmed(&image, &noisy);
        assert_eq!(dimmed.channels[0].mean, [KEPT, 2.0, 3.0 * KEPT, 4.0]);
        assert_eq!(dimmed.channels[0].variance.as_ref().unwrap()[1], 0.1);
        assert!((relative_error(&image, &noisy) - 0.7f64.sqrt() / 4.0).abs() < 1e-12);
    }

    #[test]
    fn bars_are_asked_for() {
        let row = |rejected, power| Row {
            scene: String::new(),
            pairs: 50,
            rejected,
            samples: 1,
            power,
            standard_error: 0.0,
        };
        let rows = |rejected: usize, weak: usize| -> Vec<Row> {
            (0..20).map(|i| row(usize::from(i < rejected), if i < weak { 0.5 } else { 1.0 })).collect()
        };
        assert_eq!(conclude(&rows(10, 3)).0, Verdict::Equivalent);
        assert_eq!(conclude(&rows(10, 4)).0, Verdict::Different);
        assert_eq!(conclude(&rows(2, 0)).0, Verdict::Different);
        assert_eq!(conclude(&rows(0, 0)).0, Verdict::Different);
    }
}
