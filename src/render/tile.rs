//! The part of an image that one thread makes at a time.

use super::sample::SampleMaker;
use super::splats::Splats;
use super::{LISTED, Progress, Report};
use crate::film::ChannelAccumulator;
use crate::film::Window;
use crate::integrator::Counters;
use crate::integrator::path::reuse;
use crate::sampler::SampleId;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Camera samples that are handed to a kernel at once: many, so that what it needs is set up rarely.
pub const BATCH: usize = 512;

/// The samples that were rendered of a window.
pub struct Tile {
    pub window: Window,
    /// Sums, pixel by pixel and channel by channel.
    pub sums: Vec<ChannelAccumulator>,
    /// The report of these samples.
    pub report: Report,
}

impl Tile {
    /// Of a window without samples.
    pub fn new(window: Window, channels: usize) -> Self {
        let sums = vec![ChannelAccumulator::default(); channels * window.pixels()];
        Self { window, sums, report: Report::default() }
    }

    /// Adds samples of all pixels. `None` if told to stop.
    pub fn render(
        &mut self,
        maker: &SampleMaker,
        splats: &Splats,
        channels: usize,
        samples: &Range<u64>,
        progress: &Progress,
    ) -> Option<()> {
        let Self { window, sums, report } = self;
        let mut counters = Counters::default();
        let mut values = vec![0.0; channels * BATCH];
        batches(maker, *window, samples, |which| {
            if progress.stop.load(Ordering::Relaxed) {
                return None;
            }
            let values = &mut values[..channels * which.len()];
            maker.samples(which, &mut counters, values);
            let before = report.samples;
            for (&id, values) in which.iter().zip(values.chunks_exact_mut(channels)) {
                if let Some(at) = window.index_of(id.pixel) {
                    let sums = &mut sums[at * channels..][..channels];
                    add(maker, splats, id, values, sums, report);
                }
            }
            progress.done.fetch_add(report.samples - before, Ordering::Relaxed);
            Some(())
        })?;
        report.count(&counters);
        Some(())
    }
}

/// Hands out the samples of a window in batches, with what else is needed to make them.
pub fn batches(
    maker: &SampleMaker,
    window: Window,
    samples: &Range<u64>,
    mut make: impl FnMut(&[SampleId]) -> Option<()>,
) -> Option<()> {
    let mut which = Vec::with_capacity(BATCH);
    let mut make = |which: &mut Vec<_>| {
        make(which)?;
        which.clear();
        Some(())
    };
    if maker.reuse() == 1 {
        // Pixel by pixel, and each pixel's samples in order.
        for i in 0..window.pixels() {
            for sample in samples.clone() {
                which.push(SampleId { pixel: window.pixel(i), sample });
                if which.len() == BATCH {
                    make(&mut which)?;
                }
            }
        }
    } else {
        // Cell by cell and sample by sample, with those pixels of a cell that others of it need, within the
        // window or not.
        const CELL: u32 = reuse::CELL;
        let (columns, rows) = (
            window.x / CELL..=(window.x + window.width - 1) / CELL,
            window.y / CELL..=(window.y + window.height - 1) / CELL,
        );
        for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
            for sample in samples.clone() {
                which.extend(reuse::cell((x * CELL, y * CELL), sample, maker.film().size));
                if which.len() + (CELL * CELL) as usize > BATCH {
                    make(&mut which)?;
                }
            }
        }
    }
    if which.is_empty() { Some(()) } else { make(&mut which) }
}

/// Adds a camera sample and its splats to the sums of its pixel.
#[inline]
pub fn add(
    maker: &SampleMaker,
    splats: &Splats,
    id: SampleId,
    values: &mut [f64],
    sums: &mut [ChannelAccumulator],
    report: &mut Report,
) {
    splats.add_to(id, values);
    maker.complete(values);
    let mut finite = true;
    for (sum, value) in sums.iter_mut().zip(values) {
        sum.add(id.sample, *value);
        finite &= value.is_finite();
    }
    report.samples += 1;
    if !finite {
        report.non_finite += 1;
        report.first_non_finite.push(id);
        if report.first_non_finite.len() > 2 * LISTED {
            report.list_first();
        }
    }
}
