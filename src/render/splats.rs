//! Splats: what light paths contribute to the pixels of a window.
//!
//! The light paths of sample number s have the numbers s M .. (s + 1) M. What they contribute to a pixel is
//! added to that pixel's camera sample s, in the order of their numbers: so a sample of a pixel is still a
//! function of scene, seed, pixel and number, and all that holds for samples (merging, blocks, variances)
//! holds for both together.

use super::Progress;
use super::light_path_noise::{Collector, LightPathNoise};
use super::sample::SampleMaker;
use crate::film::Window;
use crate::integrator::Counters;
use crate::sampler::SampleId;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Light paths that one thread traces at once.
const CHUNK: u64 = 1024;

/// Light paths whose splats are kept at once, if a pass can be made that short: some tens of megabytes.
pub const MANY: u64 = 1 << 19;

/// The splats of a range of samples upon a window, pixel by pixel, each pixel's in the order of their light
/// paths.
#[derive(Debug, Default)]
pub struct Splats {
    window: Option<Window>,
    channels: usize,
    /// Where each pixel's splats begin, and where the last one's end.
    first: Vec<usize>,
    /// Sample number of each splat, counted from the first of the range.
    samples: Vec<u32>,
    begin: u64,
    /// All channels of each splat.
    values: Vec<f64>,
    /// What they do to the noise of the window's mean: in pieces, and in an order, that do not depend on where passes
    /// begin.
    pub noise: Vec<LightPathNoise>,
    pub counters: Counters,
}

/// The splats of some light paths, in their order.
#[derive(Default)]
struct Part {
    pixels: Vec<u32>,
    samples: Vec<u32>,
    values: Vec<f64>,
    /// Sample by sample.
    noise: Vec<LightPathNoise>,
    counters: Counters,
}

impl Splats {
    /// Traces the light paths of a range of samples; there are no splats if the scene has no light paths.
    /// `None` if told to stop.
    pub fn trace(
        maker: &SampleMaker,
        window: Window,
        samples: &Range<u64>,
        progress: &Progress,
    ) -> Option<Self> {
        let per_sample = maker.light_paths();
        let numbers = samples.start * per_sample..samples.end * per_sample;
        // Cut at the same places whatever the range, so that sums over light paths are the same.
        let chunks = numbers.start / CHUNK..numbers.end.div_ceil(CHUNK);
        let part = |chunk: u64| {
            let (mut part, mut noise) = (Part::default(), Collector::default());
            if progress.stop.load(Ordering::Relaxed) {
                return None;
            }
            let Part { pixels, samples: offsets, values, counters, .. } = &mut part;
            let chunk = numbers.start.max(chunk * CHUNK)..numbers.end.min((chunk + 1) * CHUNK);
            maker.trace_light(chunk, counters, |number, pixel, channels| {
                let Some(at) = window.index_of(pixel) else { return };
                let sample = number / per_sample;
                noise.note(sample, number, at as u32, channels);
                pixels.push(at as u32);
                offsets.push((sample - samples.start) as u32);
                values.extend_from_slice(channels);
            });
            part.noise = noise.finish();
            Some(part)
        };
        let parts = chunks.into_par_iter().map(part).collect::<Option<Vec<Part>>>()?;
        let channels = maker.color_channels();
        Some(Self { begin: samples.start, ..Self::sorted(&parts, window, channels) })
    }

    /// A counting sort by pixel, which keeps the order within each.
    fn sorted(parts: &[Part], window: Window, channels: usize) -> Self {
        let mut first = vec![0; window.pixels() + 1];
        for pixel in parts.iter().flat_map(|part| &part.pixels) {
            first[*pixel as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let count = first[window.pixels()];
        let (mut samples, mut values) = (vec![0; count], vec![0.0; count * channels]);
        let mut next = first.clone();
        let (mut noise, mut counters) = (vec![], Counters::default());
        for part in parts {
            noise.extend_from_slice(&part.noise);
            for (i, pixel) in part.pixels.iter().enumerate() {
                let at = next[*pixel as usize];
                next[*pixel as usize] += 1;
                samples[at] = part.samples[i];
                values[at * channels..][..channels].copy_from_slice(&part.values[i * channels..][..channels]);
            }
            counters.add(&part.counters);
        }
        Self { window: Some(window), channels, first, samples, begin: 0, values, noise, counters }
    }

    /// Adds to a sample of a pixel, whose colour channels come first, what light paths contribute to it.
    #[inline(always)]
    pub fn add_to(&self, id: SampleId, values: &mut [f64]) {
        if let Some(window) = self.window {
            self.add_in(window, id, values);
        }
    }

    fn add_in(&self, window: Window, SampleId { pixel, sample }: SampleId, values: &mut [f64]) {
        let Some(at) = window.index_of(pixel) else { return };
        let sample = (sample - self.begin) as u32;
        let mine = self.first[at]..self.first[at + 1];
        let begin = mine.start + self.samples[mine.clone()].partition_point(|s| *s < sample);
        for i in (begin..mine.end).take_while(|i| self.samples[*i] == sample) {
            for (value, splat) in values.iter_mut().zip(&self.values[i * self.channels..][..self.channels]) {
                *value += splat;
            }
        }
    }
}
