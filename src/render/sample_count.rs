//! The number of samples that a requested time or error needs.
//!
//! A pilot renders a few samples with a seed of its own and is thrown away. The image is the plain render of
//! samples 0..N with the seed that was asked for, so `--spp N` makes it again, and N is independent of the
//! image's samples: no optional stopping, no weights that depend on the data, no bias.
//!
//! **Error.** After n samples a pixel the estimated variance of the image's mean is R², relative to its square, and it
//! is known how that falls ([`super::law`]): to R² ρ(N) after N samples, ρ = n/N where they are independent. R² is
//! uncertain by the relative variance r², and the more so the farther its law is followed; the mean by which it is
//! divided has the relative error R, so its square 2R. The error found after the render is uncertain in the same way,
//! less by n/N. So N is the least number with
//!
//! R² ρ(N) · (1 + 2 √(r²(N) + r² min(1, n/N) + 4 R²)) ≤ E².
//!
//! Most numbers are no good to a sequence whose first 2ᵏ points are stratified: N has at most `DIGITS` binary digits
//! before zeros follow.
//!
//! The pilot doubles until it has taken an eighth of N, or that uncertainty is small and there is no law but that of
//! independent samples. 1/r² is, where these are few, the number of pixels that would make this much noise if all were
//! alike; the tails are heavy then: a few samples decide the estimate, and the samples that nobody has seen yet may be
//! larger.

use super::passes::{Partial, render_passes};
use super::quality::Quality;
use super::{Progress, RenderError, Settings};
use crate::film::BLOCK;
use crate::scene::Scene;
use std::ops::{ControlFlow, Range};
use std::time::Instant;

/// Bits in which the seed of a pilot differs from that of the image.
const OTHER_SEED: u32 = 0x8000_0000;

/// The last possible sample of a pixel, rounded down to a block.
const MOST: u64 = (u32::MAX as u64 / BLOCK) * BLOCK;

/// Fewest samples from which a variance is estimated (four blocks).
const FEWEST: u64 = 4 * BLOCK;

/// Uncertainty of the estimated variance that ends a pilot.
const CERTAIN: f64 = 0.05;

/// Digits of a number of samples.
const DIGITS: u32 = 5;

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
    let mut needed = None;
    let quality_of = |partial: &Partial| Quality::of(partial, scene, settings.window);
    let pilot = run(scene, settings, progress, |partial| {
        // How long passes are is a matter of time, but each power of two is the end of one.
        if partial.samples.end < FEWEST || !partial.samples.end.is_power_of_two() {
            return ControlFlow::Continue(());
        }
        let quality = quality_of(partial);
        needed = needed_for(&quality, &partial.samples, target);
        let Some(needed) = needed else { return ControlFlow::Break(()) };
        let certain = quality.law.is_none_or(|law| law.gain_deviation == 0.0)
            && uncertainty(&quality, &partial.samples, needed) <= CERTAIN;
        if certain || partial.samples.end >= needed / 8 {
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
    let count = needed.ok_or(NoCount::TooMany)?;
    // A pilot without noise says nothing of what it has not met, so the image has as many samples as that.
    let no_noise = quality.relative_standard_error_of_mean == 0.0;
    let count = if no_noise { pilot.samples.end } else { count };
    Ok(Pilot { count, samples: pilot.samples.end, rays: pilot.report.rays, quality })
}

/// The least number of samples whose error is `target`, by what is known after these; `None` if there is none.
fn needed_for(quality: &Quality, samples: &Range<u64>, target: f64) -> Option<u64> {
    let squared = quality.relative_standard_error_of_mean * quality.relative_standard_error_of_mean;
    let suffices = |count: &u64| {
        let margin = 1.0 + 2.0 * uncertainty(quality, samples, *count);
        squared * quality.growth(samples, *count) * margin <= target * target
    };
    counts().find(suffices)
}

/// How uncertain it is that so many samples have the error that these promise: of the squared errors' ratio, one standard
/// deviation.
fn uncertainty(quality: &Quality, samples: &Range<u64>, count: u64) -> f64 {
    let relative = quality.relative_standard_error_of_mean;
    let then = quality.law.map_or(quality.uncertainty, |law| {
        quality.uncertainty - law.uncertainty + law.uncertainty_after(count)
    });
    let found = quality.uncertainty * ((samples.end - samples.start) as f64 / count as f64).min(1.0);
    (then.max(0.0) + found + 4.0 * relative * relative).sqrt()
}

/// All numbers of samples that are considered, from two blocks on, the fewest that have a variance at all.
fn counts() -> impl Iterator<Item = u64> {
    let least = 1u64 << (DIGITS - 1);
    let below = (2..least / BLOCK).map(|blocks| blocks * BLOCK);
    let octaves = (0..).flat_map(move |octave| (least..2 * least).map(move |digits| digits << octave));
    below.chain(octaves.filter(|count| count.is_multiple_of(BLOCK))).take_while(|count| *count <= MOST)
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
