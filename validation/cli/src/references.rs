//! The reference scenes, rendered by Etalon and compared with Mitsuba's images of them.

use crate::files;
use etalon::render::{Progress, Settings, render};
use etalon::scene::Overrides;
use etalon::spectrum::ColorMode;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use validation::Outcome;
use validation::image::{self, Comparison};

/// A scene, a colour mode, and the image to compare with.
#[derive(Clone, Debug)]
pub struct Reference {
    pub name: String,
    pub scene: PathBuf,
    pub image: PathBuf,
    pub mode: ColorMode,
    /// The standard error of each channel's mean, from independent replicates.
    errors: Vec<(String, f64)>,
}

/// The entry of an image in `references.json`.
#[derive(Deserialize)]
struct Record {
    channels: Vec<String>,
    standard_error: Vec<f64>,
}

/// The folder of the references.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../references")
}

/// All references below a folder, sorted by name.
pub fn references(folder: &Path) -> Result<Vec<Reference>, String> {
    let list = folder.join("references.json");
    let records: BTreeMap<String, Record> = files::json(&list)?;
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut found = vec![];
    for entry in entries.filter_map(Result::ok) {
        let file = entry.file_name().to_string_lossy().into_owned();
        for mode in [ColorMode::Rgb, ColorMode::Spectral] {
            if let Some(stem) = file.strip_suffix(&format!(".{}.exr", mode.name())) {
                let scene = folder.join("scenes").join(format!("{stem}.xml"));
                let name = format!("{stem}::{}", mode.name());
                let record = records.get(&format!("{stem}.{}", mode.name()));
                let Record { channels, standard_error } =
                    record.ok_or_else(|| format!("{}: there is no {file}", list.display()))?;
                let errors = channels.iter().cloned().zip(standard_error.iter().copied()).collect();
                found.push(Reference { name, scene, image: entry.path(), mode, errors });
            }
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

impl Reference {
    /// Mitsuba's image. Where its filter is wider than a pixel, pixels share samples: the sum of their
    /// variances then underestimates the variance of the mean, and the variances are enlarged to compensate.
    pub fn image(&self) -> Result<image::Image, String> {
        let image = image::load(&self.image).map_err(|e| e.to_string())?;
        let factors = image.shared_noise_of_means(self.errors.iter().map(|(name, error)| (name, error)));
        Ok(image.with_variances_times(&factors))
    }

    /// Etalon's image, with `samples` samples per pixel. `number` determines the seed.
    pub fn render(&self, samples: u32, number: u64) -> Result<image::Image, String> {
        let seed = validation::statistics::seed_for(&self.name, number) as u32;
        // Independent samples, because the pixel variance of stratified ones is an overestimate.
        let overrides =
            Overrides { seed: Some(seed), sampler: Some("independent".into()), ..Overrides::default() };
        let scene = etalon::load(&self.scene, &[], self.mode, &overrides).map_err(|e| e.to_string())?;
        let settings = Settings { seed, threads: 0, ..Settings::of(&scene, 0..u64::from(samples)) };
        let (rendered, _) = render(&scene, &settings, &Progress::default()).map_err(|e| e.to_string())?;
        let mut ours = image::Image {
            width: rendered.crop.width as usize,
            height: rendered.crop.height as usize,
            channels: rendered.channels.iter().map(channel).collect(),
        };
        // Mitsuba names the channels of a specfilm as the scene file does.
        for band in &scene.sensor.film.bands {
            for channel in ours.channels.iter_mut().filter(|channel| channel.name == band.channel) {
                channel.name.clone_from(&band.name);
            }
        }
        Ok(ours)
    }

    /// Renders with `samples` samples per pixel and compares. `number` determines the seed.
    pub fn compare(
        &self,
        samples: u32,
        settings: &image::Settings,
        number: u64,
    ) -> Result<Comparison, String> {
        let mut ours = self.render(samples, number)?;
        let reference = self.image()?;
        // Etalon writes colours beside the bands of a specfilm, Mitsuba does not.
        ours.channels.retain(|own| reference.channels.iter().any(|theirs| theirs.name == own.name));
        let comparison = image::compare(&reference, &ours, settings).map_err(|e| e.to_string())?;
        match comparison.uncompared.first() {
            Some(lost) => Err(format!("{}: there is no channel {lost}", self.name)),
            None => Ok(comparison),
        }
    }

    /// The comparison as an outcome.
    pub fn check(&self, samples: u32, margin: f64, number: u64) -> Result<Outcome, String> {
        Ok(self.compare(samples, &settings(margin), number)?.outcome().of(&self.name))
    }
}

/// Relative difference of values without noise that is none: other renderers add samples up in `f32`, which
/// leaves errors of a few ulps.
pub const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// Settings of the comparison with a reference.
pub fn settings(margin: f64) -> image::Settings {
    image::Settings { rounding: ROUNDING, ..image::Settings::with_margin(margin).with_tiles_within_noise() }
}

fn channel(channel: &etalon::image::Channel) -> image::Channel {
    let double = |values: &Vec<f32>| values.iter().map(|&v| v as f64).collect();
    image::Channel {
        name: channel.name.clone(),
        mean: double(&channel.mean),
        variance: channel.variance.as_ref().map(double),
    }
}
