//! The comparison of Etalon and Mitsuba on one scene.

use super::grammar::{SIZE, Scene};
use super::mitsuba::{Job, Mitsuba, Reply};
use etalon::render::{Progress, Settings, render};
use etalon::spectrum::ColorMode;
use serde::Serialize;
use std::path::Path;
use validation::Verdict;
use validation::image::{self, Channel, Image, compare};
use validation::statistics::seed_for;

/// Number of independent pictures from which Mitsuba's variance is estimated.
const REPLICATES: u32 = 16;

/// Samples per pixel of the first comparison.
const FIRST: u32 = 512;

/// Largest relative difference of a channel's mean that counts as equivalent.
const MARGIN: f64 = 0.005;

/// The result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    Equivalent,
    Inconclusive,
    Different,
    /// Etalon's picture has samples that are not finite.
    NotFinite,
    /// Neither renderer accepts the scene.
    RefusedByBoth,
    RefusedByEtalon,
    RefusedByMitsuba,
}

impl Answer {
    /// Whether nothing was found.
    pub fn is_clean(self) -> bool {
        matches!(self, Self::Equivalent | Self::Inconclusive | Self::RefusedByBoth)
    }
}

/// Why a scene was not judged.
#[derive(Debug)]
pub enum Failure {
    /// Mitsuba's process ended, or said what is no answer.
    Mitsuba(String),
    /// A file of our own cannot be written or read.
    Own(String),
}

/// A line of the record, about one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Judgement {
    /// Number of the scene.
    pub number: u64,
    pub answer: Answer,
    pub mode: &'static str,
    /// Samples per pixel, of either renderer.
    pub samples: u32,
    /// Etalon's mean over Mitsuba's, for each channel.
    pub ratios: Vec<(String, f64)>,
    pub message: String,
    pub models: Vec<String>,
}

impl Judgement {
    /// The record of a scene at which Mitsuba's process ended.
    pub fn died(scene: &Scene, number: u64, message: String) -> Self {
        let (answer, models) = (Answer::RefusedByMitsuba, scene.models.clone());
        Self { number, answer, mode: scene.mode, samples: 0, ratios: vec![], message, models }
    }
}

/// Renders with more and more samples until the verdict is clear, or would need more than `most`. A
/// difference counts if a comparison with four times the samples and other seeds confirms it.
pub fn judge(
    scene: &Scene,
    number: u64,
    folder: &Path,
    mitsuba: &mut Mitsuba,
    most: u32,
) -> Result<Judgement, Failure> {
    let file = folder.join(format!("{number}.xml"));
    let own = |error: std::io::Error| Failure::Own(format!("{}: {error}", file.display()));
    std::fs::write(&file, &scene.text).map_err(own)?;
    // Both renderers take whole samples of each replicate, and whole blocks.
    const STEP: u32 = 4 * REPLICATES;
    let largest = most / STEP * STEP;
    let (mut samples, mut doubted) = (FIRST.min(largest), false);
    loop {
        let name = format!("{number} {samples} {doubted}");
        let (mut found, more) = once(scene, &file, &name, samples, mitsuba)?;
        found.number = number;
        // Messages must not depend on the folder.
        found.message = found.message.replace(&format!("{}/", folder.display()), "");
        let wanted = match found.answer {
            Answer::Different if !doubted => 4.0,
            // A little more than the count estimated to decide with 90 % power.
            Answer::Inconclusive => more.map_or(f64::INFINITY, |factor| 1.2 * factor.max(1.0)),
            _ => f64::INFINITY,
        };
        let next = f64::from(samples) * wanted;
        let to_confirm = found.answer == Answer::Different && !doubted;
        let next_samples = (next.min(f64::from(largest)) as u32).next_multiple_of(STEP);
        if (next > f64::from(most) || next_samples <= samples) && !to_confirm {
            if matches!(found.answer, Answer::Equivalent | Answer::RefusedByBoth) {
                std::fs::remove_file(&file).map_err(own)?;
            }
            return Ok(found);
        }
        doubted |= found.answer == Answer::Different;
        samples = next_samples;
    }
}

/// One comparison, and the factor by which more samples would decide it.
fn once(
    scene: &Scene,
    file: &Path,
    name: &str,
    samples: u32,
    mitsuba: &mut Mitsuba,
) -> Result<(Judgement, Option<f64>), Failure> {
    let out = file.with_extension("exr");
    let spp = samples / REPLICATES;
    let job = Job { scene: file, out: &out, name, mode: scene.mode, spp, replicates: REPLICATES };
    mitsuba.send(&job).map_err(Failure::Mitsuba)?;
    let ours = picture(scene, file, seed_for(name, 0) as u32, samples);
    let reply = mitsuba.receive().map_err(Failure::Mitsuba)?;
    let mut found = Judgement {
        number: 0,
        answer: Answer::RefusedByBoth,
        mode: scene.mode,
        samples,
        ratios: vec![],
        message: String::new(),
        models: scene.models.clone(),
    };
    let theirs = match &reply.error {
        Some(their_words) => Err(their_words.clone()),
        None => {
            let picture = image::load(&out).map_err(|e| Failure::Own(e.to_string()))?;
            std::fs::remove_file(&out).map_err(|e| Failure::Own(format!("{}: {e}", out.display())))?;
            Ok(picture)
        }
    };
    let (ours, theirs) = match (ours, theirs) {
        (Ok(ours), Ok(theirs)) => (ours, theirs),
        (Err(NoPicture::NotFinite(words)), _) => {
            (found.answer, found.message) = (Answer::NotFinite, words);
            return Ok((found, None));
        }
        (Err(NoPicture::Refused(our_words)), theirs) => {
            found.message = our_words;
            if theirs.is_ok() {
                found.answer = Answer::RefusedByEtalon;
            }
            return Ok((found, None));
        }
        (Ok(_), Err(their_words)) => {
            (found.answer, found.message) = (Answer::RefusedByMitsuba, their_words);
            return Ok((found, None));
        }
    };
    let theirs = if scene.boxed { theirs } else { with_shared_noise(theirs, &reply) };
    let (theirs, ours) = shifted(silenced(theirs), silenced(ours));
    // As for the stored references: Mitsuba accumulates samples in f32.
    let rounding = 64.0 * f64::from(f32::EPSILON);
    let settings =
        image::Settings { rounding, ..image::Settings::with_margin(MARGIN).with_tiles_within_noise() };
    let comparison = match compare(&theirs, &ours, &settings) {
        Ok(comparison) => comparison,
        // Pictures that cannot be compared, as those of other sizes, are not the same.
        Err(why) => {
            (found.answer, found.message) = (Answer::Different, why.to_string());
            return Ok((found, None));
        }
    };
    found.answer = match comparison.verdict {
        Verdict::Equivalent => Answer::Equivalent,
        Verdict::Inconclusive => Answer::Inconclusive,
        Verdict::Different => Answer::Different,
    };
    let average = |c: &Channel| c.mean.iter().sum::<f64>() / c.mean.len() as f64;
    let ratio = |c: &Channel| {
        let other = theirs.channels.iter().find(|t| t.name == c.name)?;
        let ratio = average(c) / average(other);
        Some((c.name.clone(), (ratio * 1e6).round() / 1e6))
    };
    found.ratios = ours.channels.iter().filter_map(ratio).collect();
    found.message = comparison.message;
    Ok((found, comparison.more_samples))
}

/// Why Etalon has no picture of a scene to compare.
enum NoPicture {
    Refused(String),
    NotFinite(String),
}

/// Renders the scene with Etalon.
fn picture(scene: &Scene, file: &Path, seed: u32, samples: u32) -> Result<Image, NoPicture> {
    let mode = if scene.mode == "rgb" { ColorMode::Rgb } else { ColorMode::Spectral };
    let loaded = etalon::load_text(&file.to_string_lossy(), &scene.text, mode);
    let loaded = loaded.map_err(|e| NoPicture::Refused(e.to_string()))?;
    let settings = Settings { seed, ..Settings::of(&loaded, 0..u64::from(samples)) };
    let rendered = render(&loaded, &settings, &Progress::default());
    let (image, report) = rendered.map_err(|e| NoPicture::Refused(e.to_string()))?;
    if report.non_finite > 0 {
        let words = format!("{} samples are not finite: {:?}", report.non_finite, report.first_non_finite);
        return Err(NoPicture::NotFinite(words));
    }
    let double = |values: &Vec<f32>| values.iter().map(|&v| f64::from(v)).collect();
    let channel = |c: &etalon::image::Channel| Channel {
        // Mitsuba names the channels of a specfilm as the scene file does.
        name: loaded
            .sensor
            .film
            .bands
            .iter()
            .find(|b| b.channel == c.name)
            .map_or(&c.name, |b| &b.name)
            .clone(),
        mean: double(&c.mean),
        variance: c.variance.as_ref().map(double),
    };
    let (width, height) = (SIZE as usize, SIZE as usize);
    Ok(Image { width, height, channels: image.channels.iter().map(channel).collect() })
}

/// Sets pixels below 10⁻¹⁵ of the brightest to 0: an `f32` cannot hold the variance of the darkest of them,
/// and Mitsuba has no denormal numbers.
fn silenced(mut image: Image) -> Image {
    for channel in &mut image.channels {
        let least = 1e-15 * channel.mean.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        channel.mean.iter_mut().filter(|v| v.abs() < least).for_each(|v| *v = 0.0);
    }
    image
}

/// Shifts channels that are no colours and may be negative, such as normals, above 0: a relative difference
/// is meaningless for a mean near 0.
fn shifted(mut a: Image, mut b: Image) -> (Image, Image) {
    for channel in a.channels.iter_mut().filter(|c| !["R", "G", "B"].contains(&c.name.as_str())) {
        let (low, high) = channel.mean.iter().fold((0.0f64, 0.0f64), |(l, h), v| (l.min(*v), h.max(v.abs())));
        let Some(other) = b.channels.iter_mut().find(|c| c.name == channel.name && low < 0.0) else {
            continue;
        };
        channel.mean.iter_mut().chain(&mut other.mean).for_each(|v| *v += 2.0 * high);
    }
    (a, b)
}

/// Mitsuba's picture with variances that add up to the variance of its mean: where samples count in several
/// pixels, the pixels' noise is correlated. The factor depends on the filter, and each channel estimates it
/// to within a third, so the largest estimate is used for all.
fn with_shared_noise(image: Image, reply: &Reply) -> Image {
    let factors = image.shared_noise_of_means(reply.channels.iter().zip(&reply.standard_error));
    let factor = factors.into_iter().map(|(_, factor)| factor).fold(1.0, f64::max);
    let factors: Vec<_> = image.channels.iter().map(|channel| (channel.name.clone(), factor)).collect();
    image.with_variances_times(&factors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_noise_adds_up_to_that_of_the_mean() {
        let channel =
            |name: &str| Channel { name: name.into(), mean: vec![1.0, 3.0], variance: Some(vec![0.5, 1.5]) };
        let image = Image { width: 2, height: 1, channels: vec![channel("R"), channel("G")] };
        // With independent pixels the standard error would be √(2/4).
        let reply = |errors: [f64; 2]| Reply {
            channels: vec!["R".into(), "G".into()],
            standard_error: errors.to_vec(),
            ..Reply::default()
        };
        let variances = |errors| {
            let channels = with_shared_noise(image.clone(), &reply(errors)).channels;
            channels.into_iter().map(|channel| channel.variance.unwrap()).collect::<Vec<_>>()
        };
        assert_eq!(variances([1.0, 0.5]), [vec![1.0, 3.0], vec![1.0, 3.0]]);
        assert_eq!(variances([0.1, 0.0]), [vec![0.5, 1.5], vec![0.5, 1.5]]);
    }
}
