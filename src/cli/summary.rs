//! The summary that is printed when a render is over.

use super::say;
use etalon::image::Image;
use etalon::render::quality::Quality;
use etalon::render::sample_count::Pilot;
use etalon::render::{Report, memory};
use etalon::scene::Scene;
use std::io;
use std::ops::Range;

/// A render that has been written.
pub struct Summary<'a> {
    pub scene: &'a Scene,
    pub image: &'a Image,
    /// The samples that were asked for; the image has fewer if the render was interrupted.
    pub asked: Range<u64>,
    pub report: &'a Report,
    pub quality: Quality,
    pub seconds: f64,
    pub load_seconds: f64,
    /// The sample at which a resumed render began.
    pub begun: Option<u64>,
    /// The pilot that chose the number of samples, and the seconds it took.
    pub pilot: Option<(Pilot, f64)>,
    /// Whether a pilot chose the number of samples, of this run or of one that it goes on with.
    pub chosen: bool,
    pub target_error: Option<f64>,
}

impl Summary<'_> {
    /// The samples that the image has.
    pub fn samples(&self) -> Range<u64> {
        self.image.provenance.as_ref().map_or(0..0, |p| p.samples.clone())
    }

    pub fn interrupted(&self) -> bool {
        self.samples() != self.asked
    }

    /// Whether the error that was asked for was found, if one was asked for.
    pub fn attained(&self) -> Option<bool> {
        self.target_error.map(|target| self.quality.relative_standard_error_of_mean <= target)
    }

    /// The samples that this run took, which are fewer than the image has if it was resumed.
    fn taken(&self) -> u64 {
        let before = self.begun.map_or(0, |end| end - self.asked.start);
        self.report.samples - before * self.image.crop.pixels() as u64
    }

    pub fn print(&self) -> io::Result<()> {
        let (report, quality) = (self.report, &self.quality);
        let million = |count: f64| count / self.seconds / 1e6;
        let taken = self.taken() as f64;
        let rays = report.rays as f64 * if report.samples > 0 { taken / report.samples as f64 } else { 0.0 };
        let [r, g, b] = quality.mean;
        let planning = self.scene.planning.as_secs_f64();
        say!(
            "{:.2} s rendering, {planning:.2} s planning, {:.2} s loading, {} threads, kernel `{}`",
            self.seconds,
            self.load_seconds - planning,
            report.threads,
            report.kernel
        );
        if let Some(begun) = self.begun {
            say!("resumed at sample {begun}");
        }
        say!("{:.3} million paths/s, {:.2} million rays/s", million(taken), million(rays));
        say!("mean ({r:.5}, {g:.5}, {b:.5})");
        if quality.relative_standard_error.is_finite() {
            say!("relative standard error {:.3} % a pixel", 100.0 * quality.relative_standard_error);
            say!(
                "relative standard error {:.4} % of the mean",
                100.0 * quality.relative_standard_error_of_mean
            );
        } else if !(r + g + b).is_finite() {
            say!("no relative standard error: the mean is not finite");
        } else if r + g + b != 0.0 {
            say!("no relative standard error: that takes two blocks of four samples");
        } else if self.scene.integrator.has_radiance() {
            let visible = if self.scene.sensor.film.bands.is_empty() { "" } else { "visible " };
            say!("no relative standard error: no {visible}light was seen");
        } else {
            say!("no relative standard error: the mean is 0");
        }
        if let (Some(target), Some(attained)) = (self.target_error, self.attained()) {
            let words = if attained { "attained" } else { "NOT attained" };
            say!("the {:.4} % that were asked for are {words}", 100.0 * target);
        }
        if self.chosen {
            say!("the same image again: --spp {}", self.samples().end);
        }
        Ok(())
    }

    pub fn document(&self) -> serde_json::Value {
        let (report, quality, samples) = (self.report, &self.quality, self.samples());
        let mut document = serde_json::json!({
            "seconds": self.seconds,
            "load_seconds": self.load_seconds,
            "plan_seconds": self.scene.planning.as_secs_f64(),
            "samples": report.samples,
            "samples_per_pixel": samples.end - samples.start,
            "rays": report.rays,
            "kernel": report.kernel,
            "threads": report.threads,
            "peak_memory_bytes": memory::peak(),
            "mean": quality.mean,
            "relative_standard_error": quality.relative_standard_error,
            "relative_standard_error_of_mean": quality.relative_standard_error_of_mean,
            "effective_pixels": quality.effective_pixels,
            "heavy_tailed": quality.heavy_tailed(),
            "non_finite_samples": report.non_finite,
            "cut_paths": report.cut,
            "color": self.scene.mode.name(),
            "integrator": self.scene.integrator.name(),
            "scene_hash": self.scene.hash,
            "seed": self.image.provenance.as_ref().map(|p| p.seed),
            "version": etalon::VERSION,
            "interrupted": self.interrupted(),
        });
        if let Some(begun) = self.begun {
            document["resumed_at"] = begun.into();
        }
        if self.chosen {
            document["reproduce"] = format!("--spp {}", samples.end).into();
        }
        if let Some((pilot, seconds)) = &self.pilot {
            document["pilot"] = serde_json::json!({
                "seconds": seconds,
                "samples_per_pixel": pilot.samples,
                "rays": pilot.rays,
                "effective_pixels": pilot.quality.effective_pixels,
                "heavy_tailed": pilot.quality.heavy_tailed(),
            });
        }
        if let (Some(target), Some(attained)) = (self.target_error, self.attained()) {
            document["target_error"] = target.into();
            document["attained"] = attained.into();
        }
        document
    }
}

/// A warning that an estimate has heavy tails.
pub fn heavy(quality: &Quality, whose: &str) -> String {
    format!(
        "heavy tails: {whose} noise is that of about {:.0} of {} pixels; the standard error may be underestimated",
        quality.effective_pixels, quality.pixels
    )
}
