//! Scenes whose image has an analytic solution.
//!
//! A case is data: a scene, a number computed from a formula by code that shares nothing with the renderer,
//! and the quantity of the image that must equal it. The verdict comes from renders with different seeds:
//! Student's interval of their values must lie within the margin (two one-sided tests). So neither the
//! image's own variance nor the independence of its pixels is relied on.
//!
//! *How to add one*: an entry in the `cases` of the file it belongs to; for a new family, a file and its line
//! in [`FAMILIES`]. The formula's source stands in `source`, its derivation beside the code.

mod cameras;
mod colors;
mod envmap;
pub(crate) mod interfaces;
mod interreflection;
pub(crate) mod irradiance;
mod lambert;
mod media;
pub(crate) mod metals;
mod meters;
mod mixtures;
mod plastic;
mod prism;
mod round_lights;
mod small_lights;
mod surroundings;
mod table;
mod textures;
mod thin_lens;
mod vanishing;

use crate::stage::{Family, TWICE, confirmed, expose, fault, gather, load, measured};
use etalon::render::Settings;
use etalon::spectrum::ColorMode;
use etalon::spectrum::observer::luminance;
use std::collections::BTreeMap;
pub use table::markdown;
use validation::Outcome;
use validation::image::Image;
use validation::statistics::distributions::student_quantile;
use validation::statistics::power::detectable_difference;
use validation::statistics::{Estimate, Interval, seed_for};

/// Number of renders of a case.
pub const REPLICATES: u64 = 12;

/// The probability with which an interval misses the true value.
pub const LEVEL: f64 = 0.01;

/// A scene and its analytic solution.
#[derive(Clone, Debug)]
pub struct ClosedForm {
    pub name: String,
    /// The formula with its source.
    pub source: &'static str,
    pub scene: String,
    pub mode: ColorMode,
    /// The compared quantity of an image.
    pub measure: Measure,
    /// The analytic value of that quantity.
    pub expected: f64,
    /// Largest relative deviation that counts as equivalent.
    pub margin: f64,
    /// Samples per pixel of each render.
    pub samples: u64,
}

/// A quantity of an image that is compared.
pub type Measure = fn(&Image) -> f64;

/// All families, by name.
pub const FAMILIES: &[Family<ClosedForm>] = &[
    ("irradiance", irradiance::cases),
    ("round_lights", round_lights::cases),
    ("small_lights", small_lights::cases),
    ("surroundings", surroundings::cases),
    ("vanishing", vanishing::cases),
    ("envmap", envmap::cases),
    ("interreflection", interreflection::cases),
    ("interfaces", interfaces::cases),
    ("metals", metals::cases),
    ("plastic", plastic::cases),
    ("mixtures", mixtures::cases),
    ("media", media::cases),
    ("cameras", cameras::cases),
    ("meters", meters::cases),
    ("thin_lens", thin_lens::cases),
    ("prism", prism::cases),
    ("colors", colors::cases),
    ("textures", textures::cases),
];

/// All cases, named `family::case`.
pub fn cases() -> Vec<ClosedForm> {
    gather(FAMILIES, |case| &mut case.name)
}

impl ClosedForm {
    /// A case that compares the luminance of the whole image to ±0.1 %, with few samples, in RGB mode.
    pub fn new(name: impl Into<String>, source: &'static str, scene: String, expected: f64) -> Self {
        Self {
            name: name.into(),
            source,
            scene,
            mode: ColorMode::Rgb,
            measure: mean_luminance,
            expected,
            margin: 0.001,
            samples: 1 << 12,
        }
    }

    pub fn spectral(self) -> Self {
        Self { mode: ColorMode::Spectral, ..self }
    }

    pub fn measure(self, measure: Measure) -> Self {
        Self { measure, ..self }
    }

    pub fn margin(self, margin: f64) -> Self {
        Self { margin, ..self }
    }

    pub fn samples(self, samples: u64) -> Self {
        Self { samples, ..self }
    }

    /// Renders with `effort` times the samples and judges; `number` determines the seeds.
    pub fn check(&self, effort: u64, number: u64) -> Result<Outcome, String> {
        let scene = load(&self.scene, self.mode).map_err(|e| format!("{}: {e}", self.name))?;
        let mut images = vec![];
        for replicate in 0..REPLICATES {
            let seed = seed_for(&self.name, number * REPLICATES + replicate) as u32;
            let settings = Settings { seed, ..Settings::of(&scene, 0..self.samples * effort) };
            images.push(measured(&expose(&scene, &settings)?));
        }
        Ok(self.judge_images(&images, LEVEL))
    }

    /// The verdict on renders with different seeds, at this level.
    pub fn judge_images(&self, images: &[Image], level: f64) -> Outcome {
        self.judge(Estimate::of(images.iter().map(|image| (self.measure)(image) / self.expected)), level)
    }

    /// The scene as a file that may be in any folder: files that it names are searched beside the reference
    /// scenes.
    pub fn standing_alone(&self) -> String {
        let place = crate::references::folder().join("scenes");
        let path = format!("><path value=\"{}\"/>", place.display());
        self.scene.replacen('>', &path, 1)
    }

    /// The verdict on an estimate of measured / expected.
    fn judge(&self, ratio: Estimate, level: f64) -> Outcome {
        let error = ratio.variance.sqrt();
        let interval = Interval::around(ratio.mean, student_quantile(level, ratio.degrees) * error);
        let verdict = interval.verdict(1.0, self.margin);
        let [deviation, low, high] = [ratio.mean, interval.low, interval.high].map(|v| 100.0 * (v - 1.0));
        let margin = 100.0 * self.margin;
        let message = format!("{deviation:+.4} % ({low:+.4} to {high:+.4} %), margin {margin} %");
        let figures = BTreeMap::from([
            ("expected".to_string(), self.expected),
            ("ratio".to_string(), ratio.mean),
            ("ratio.low".to_string(), interval.low),
            ("ratio.high".to_string(), interval.high),
            ("margin".to_string(), self.margin),
        ]);
        let outcome = Outcome::new("closed form", verdict, message).of(&self.name);
        Outcome { figures, ..outcome.detectable(detectable_difference(error, level, ratio.degrees)) }
    }

    /// The case as a test: it fails if four times the samples with other seeds confirm an inconclusive or
    /// different verdict.
    pub fn test(&self) -> Result<(), String> {
        confirmed(&TWICE, |effort, number| Ok(fault(&self.check(effort, number)?)))
            .map_err(|message| format!("{message}; {}", self.source))
    }
}

/// The mean of a channel; NaN, which no verdict passes, if there is no such channel.
pub fn mean(image: &Image, channel: &str) -> f64 {
    let found = image.channels.iter().find(|c| c.name == channel);
    found.map_or(f64::NAN, |c| c.mean.iter().sum::<f64>() / c.mean.len() as f64)
}

/// The mean relative luminance Y.
pub fn mean_luminance(image: &Image) -> f64 {
    luminance(["R", "G", "B"].map(|channel| mean(image, channel)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::Verdict;

    #[test]
    fn undecided_is_no_pass_and_a_shift_is_seen() {
        let case = ClosedForm::new("x", "", String::new(), 1.0);
        let verdict = |mean, error: f64| {
            case.judge(Estimate { mean, variance: error * error, degrees: 11.0 }, LEVEL).verdict
        };
        assert_eq!(verdict(1.0002, 1e-4), Verdict::Equivalent);
        assert_eq!(verdict(1.0002, 1e-3), Verdict::Inconclusive);
        assert_eq!(verdict(1.002, 1e-4), Verdict::Different);
        assert_eq!(verdict(f64::NAN, 1e-4), Verdict::Different);
    }

    #[test]
    fn names_are_unique_and_answers_are_numbers() {
        let mut names: Vec<String> = cases().iter().map(|c| c.name.clone()).collect();
        assert!(cases().iter().all(|c| c.expected.is_finite() && c.expected != 0.0 && c.margin <= 0.0025));
        let count = names.len();
        names.sort();
        names.dedup();
        assert!(names.len() == count && count >= 30, "{count}");
    }
}
