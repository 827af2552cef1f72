//! The number of samples that a requested time or error needs.
//!
//! A pilot renders a few samples with a seed of its own and is thrown away. The image is the plain render of
//! samples 0..N with the seed that was asked for, so `--spp N` makes it again, and N is independent of the
//! image's samples: no optional stopping, no weights that depend on the data, no bias.
//!
//! **Error.** After n samples a pixel the estimated variance of the image's mean is R², relative to its
//! square. It falls as 1/n, so an error E needs N = n R²/E² samples. R² is uncertain itself. The variances v
//! of the P pixels are independent estimates; if pixels share paths, those of the squares that share are. So
//! the variance of their sum is at most Σ v², that of the sum relative to it at most r² = Σ v²/(Σ v)²; and
//! the mean by which it is divided has the relative error R, so its square 2R. The error found after the
//! render is uncertain in the same way, less by n/N. With two standard deviations of all this,
//!
//! N = n R²/E² · (1 + 2 √(r² (1 + n/N) + 4 R²)).
//!
//! The pilot doubles until that uncertainty is small or the pilot has taken an eighth of N. 1/r² is the
//! number of pixels that would make this much noise if all were alike. Where it is small the tails are heavy:
//! a few samples decide the estimate, and the samples that nobody has seen yet may be larger.

use super::passes::{Partial, render_passes};
use super::quality::Quality;
use super::{Progress, RenderError, Settings};
use crate::film::BLOCK;
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::time::Instant;

/// Bits in which the seed of a pilot differs from that of the image.
const OTHER_SEED: u32 = 0x8000_0000;

/// The last possible sample of a pixel, rounded down to a block.
const MOST: u64 = (u32::MAX as u64 / BLOCK) * BLOCK;

/// Fewest samples from which a variance is estimated (four blocks).
const FEWEST: u64 = 4 * BLOCK;

/// Uncertainty of the estimated variance that ends a pilot.
const CERTAIN: f64 = 0.05;

/// What a pilot did and what follows from it.
#[derive(Clone, Copy, Debug)]
pub struct Pilot {
    /// Samples of every pixel to render.
    pub count: u64,
    /// Samples of every pixel that the pilot rendered.
    pub samples: u64,
    /// Rays that the pilot traced.
    pub rays: u64,
    /// Noise of the image that the pilot rendered.
    pub quality: Quality,
}

/// Why a pilot finds no number of samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoCount {
    /// The pilot did not come to its end.
    Unfinished(RenderError),
    /// The pilot saw no light, so that no error is relative to anything.
    Black,
    /// A sample was not finite.
    NonFinite,
    /// More samples would be needed than a pixel can have.
    TooMany,
}

/// The number of samples that brings the relative standard error of the image's mean to `target`.
pub fn for_error(
    scene: &Scene,
    settings: &Settings,
    target: f64,
    progress: &Progress,
) -> Result<Pilot, NoCount> {
    let mut needed = f64::INFINITY;
    let quality_of = |partial: &Partial| Quality::of(partial, scene, settings.window);
    let pilot = run(scene, settings, progress, |partial| {
        let n = partial.samples.end as f64;
        // How long passes are is a matter of time, but each power of two is the end of one.
        if partial.samples.end < FEWEST || !partial.samples.end.is_power_of_two() {
            return ControlFlow::Continue(());
        }
        let quality = quality_of(partial);
        let relative = quality.relative_standard_error_of_mean;
        let plain = n * (relative / target) * (relative / target);
        let r2 = quality.uncertainty;
        let uncertainty = (r2 * (1.0 + (n / plain).min(1.0)) + 4.0 * relative * relative).sqrt();
        needed = plain * (1.0 + 2.0 * uncertainty);
        let hopeless = !needed.is_finite() || plain > MOST as f64;
        if uncertainty <= CERTAIN || n * 8.0 >= plain || hopeless {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })?;
    let quality = quality_of(&pilot);
    if pilot.report.non_finite > 0 {
        return Err(NoCount::NonFinite);
    }
    if quality.mean.iter().sum::<f64>() == 0.0 {
        return Err(NoCount::Black);
    }
    if needed.is_nan() || needed > MOST as f64 {
        return Err(NoCount::TooMany);
    }
    // Two blocks are the fewest that have a variance at all. A pilot without noise says nothing of what it has not
    // met, so the image has as many samples as that.
    let least = if needed == 0.0 { pilot.samples.end } else { 2 * BLOCK };
    let count = (needed.ceil() as u64).next_multiple_of(BLOCK).max(least);
    Ok(Pilot { count, samples: pilot.samples.end, rays: pilot.report.rays, quality })
}

/// The number of samples that takes `seconds`, the pilot's time included. The only figure here that a clock
/// decides.
pub fn for_time(
    scene: &Scene,
    settings: &Settings,
    seconds: f64,
    progress: &Progress,
) -> Result<Pilot, NoCount> {
    let begin = Instant::now();
    let pilot = run(scene, settings, progress, |_| {
        if begin.elapsed().as_secs_f64() < seconds / 20.0 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    })?;
    let spent = begin.elapsed().as_secs_f64();
    Ok(Pilot {
        count: affordable(pilot.samples.end, spent, seconds),
        samples: pilot.samples.end,
        rays: pilot.report.rays,
        quality: Quality::of(&pilot, scene, settings.window),
    })
}

/// How many samples of a pixel there is time for: whole blocks, and one at least, where so many took `spent` of the
/// seconds.
fn affordable(samples: u64, spent: f64, seconds: f64) -> u64 {
    let count = samples as f64 * ((seconds - spent) / spent).max(0.0);
    (count.min(MOST as f64) as u64 / BLOCK * BLOCK).max(BLOCK)
}

fn run(
    scene: &Scene,
    settings: &Settings,
    progress: &Progress,
    after_pass: impl FnMut(&Partial) -> ControlFlow<()>,
) -> Result<Partial, NoCount> {
    let settings = Settings { samples: 0..MOST, seed: settings.seed ^ OTHER_SEED, ..settings.clone() };
    let begun = Partial::new(scene, &settings);
    render_passes(scene, &settings, begun, progress, after_pass).map_err(NoCount::Unfinished)
}

#[cfg(test)]
mod tests;
