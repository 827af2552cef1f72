//! Samples that count for every pixel whose filter reaches them.
//!
//! Drawn from its own pixel's filter ([`Film::place`]), a sample counts for that pixel alone, and errors of
//! pixels are independent. Where pixels may share, samples lie evenly in their own pixels instead, and what a
//! pixel has of sample number s is a sum over its neighbours' samples s, weighted by its filter
//! ([`filter_weights`](crate::film::filter_weights)). White noise then has ∫f² of its variance: 4/9 with a
//! tent of radius one, 1/π with Mitsuba's default, a gaussian.
//!
//! That sum is still a function of scene, seed, pixel and number, and all that holds for samples (merging,
//! blocks, variances) holds for it. It needs samples of the same number of pixels all around, so the whole
//! window makes a few numbers at a time.

use super::sample::SampleMaker;
use super::splats::Splats;
use super::tile::{BATCH, add, batches};
use super::{Progress, Report};
use crate::film::Window;
use crate::film::filter_weights::Weights;
use crate::film::{Accumulators, ChannelAccumulator, Film};
use crate::integrator::Counters;
use crate::integrator::path::reuse::CELL;
use crate::sampler::SampleId;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Bytes that the samples which are made together may take, if there is more than one of each pixel.
const TOGETHER: usize = 1 << 26;

/// Most samples of a pixel that are made together: enough for many threads.
const MOST: usize = 16;

/// The samples of a window.
pub struct Spread<'a> {
    maker: &'a SampleMaker<'a>,
    film: &'a Film,
    window: Window,
    /// The pixels that count for any of the window.
    around: Window,
    reach: u32,
    channels: usize,
    /// Sample by sample and row by row of those pixels, for each column of the window: all channels, summed
    /// along the row.
    columns: Vec<f64>,
}

/// A sample that is not finite. It counts for its own pixel only, where it is found and named.
struct Lost {
    id: SampleId,
    values: Vec<f64>,
}

impl Lost {
    fn row(&self) -> (u64, u32) {
        (self.id.sample, self.id.pixel.1)
    }
}

impl<'a> Spread<'a> {
    pub fn new(maker: &'a SampleMaker<'a>, window: Window, channels: usize) -> Self {
        let film = maker.film();
        let reach = film.spread.as_ref().map_or(0, |spread| spread.reach());
        let around = window.grown_within(reach, &film.crop);
        let size = channels * (around.height * window.width) as usize;
        let together = (TOGETHER / (size * size_of::<f64>())).clamp(1, MOST);
        Self { maker, film, window, around, reach, channels, columns: vec![0.0; together * size] }
    }

    /// Adds these samples of all pixels of the window to their sums, and what light paths bring to them. `None` if told
    /// to stop.
    pub fn add(
        &mut self,
        samples: &Range<u64>,
        splats: &Splats,
        sums: &mut Accumulators,
        progress: &Progress,
    ) -> Option<Report> {
        let mut report = Report::default();
        let together = (self.columns.len() / self.size()) as u64;
        for first in samples.clone().step_by(together as usize) {
            let some = first..samples.end.min(first + together);
            let lost = self.trace(&some, progress, &mut report)?;
            let length = self.channels * self.window.width as usize;
            let row = |(y, sums): (usize, &mut [ChannelAccumulator])| {
                let mut report = Report::default();
                let mut values = vec![0.0; length];
                let y = self.window.y + y as u32;
                for (n, sample) in some.clone().enumerate() {
                    self.gather(n, sample, y, &lost, &mut values);
                    let pixels = values.chunks_exact_mut(self.channels);
                    for (x, (values, sums)) in
                        (self.window.x..).zip(pixels.zip(sums.chunks_exact_mut(self.channels)))
                    {
                        let id = SampleId { pixel: (x, y), sample };
                        add(self.maker, splats, id, values, sums, &mut report);
                    }
                }
                report
            };
            let rows = sums.all_mut().par_chunks_exact_mut(length).enumerate();
            let rows: Vec<_> = rows.map(row).collect();
            rows.iter().for_each(|more| report.add(more));
            progress.done.fetch_add((some.end - first) * self.window.pixels() as u64, Ordering::Relaxed);
        }
        report.list_first();
        Some(report)
    }

    /// All channels of one sample of a window of one pixel, without what light paths bring.
    pub fn one(mut self, sample: u64) -> Vec<f64> {
        let mut values = vec![0.0; self.channels];
        if let Some(lost) = self.trace(&(sample..sample + 1), &Progress::default(), &mut Report::default()) {
            self.gather(0, sample, self.window.y, &lost, &mut values);
        }
        values
    }

    /// Numbers of a sample's columns.
    fn size(&self) -> usize {
        self.channels * (self.around.height * self.window.width) as usize
    }

    /// Traces these samples of all pixels around, and sums them along rows. What is lost is sorted by number
    /// and row.
    fn trace(&mut self, samples: &Range<u64>, progress: &Progress, report: &mut Report) -> Option<Vec<Lost>> {
        let length = self.channels * self.window.width as usize;
        let mut columns = std::mem::take(&mut self.columns);
        let mut jobs = vec![];
        let mut rest = columns.as_mut_slice();
        for (sample, band) in
            samples.clone().flat_map(|sample| self.around.bands(CELL).map(move |band| (sample, band)))
        {
            let (sums, others) = rest.split_at_mut(band.height as usize * length);
            jobs.push((sample, band, sums));
            rest = others;
        }
        let job = |(sample, band, sums): (u64, Window, &mut [f64])| self.band(sample, band, sums, progress);
        let done = jobs.into_par_iter().map(job).collect::<Option<Vec<_>>>();
        self.columns = columns;
        let mut lost = vec![];
        for (counters, found) in done? {
            report.count(&counters);
            lost.extend(found);
        }
        lost.sort_by_key(Lost::row);
        Some(lost)
    }

    /// Traces one sample of some whole rows of pixels.
    fn band(
        &self,
        sample: u64,
        band: Window,
        sums: &mut [f64],
        progress: &Progress,
    ) -> Option<(Counters, Vec<Lost>)> {
        let (mut counters, mut lost) = (Counters::default(), vec![]);
        let (channels, width) = (self.channels, band.width as usize);
        let mut row_by_row = vec![0.0; channels * band.pixels()];
        let mut values = vec![0.0; channels * BATCH];
        batches(self.maker, band, &(sample..sample + 1), |which| {
            if progress.stop.load(Ordering::Relaxed) {
                return None;
            }
            let values = &mut values[..channels * which.len()];
            self.maker.samples(which, &mut counters, values);
            for (&id, values) in which.iter().zip(values.chunks_exact(channels)) {
                let Some(at) = band.index_of(id.pixel) else { continue };
                if values.iter().all(|value| value.is_finite()) {
                    row_by_row[at * channels..][..channels].copy_from_slice(values);
                } else {
                    lost.push(Lost { id, values: values.to_vec() });
                }
            }
            Some(())
        })?;
        let place = self.maker.place_in_pixels(sample)?;
        let weights = |x: u32| self.film.weights((x, self.window.y), place).map(|[columns, _]| columns);
        let weights: Vec<_> = (self.window.x..).take(self.window.width as usize).map(weights).collect();
        let shift = self.window.x - self.around.x;
        let rows = row_by_row.chunks_exact(channels * width);
        for (row, sums) in rows.zip(sums.chunks_exact_mut(channels * self.window.width as usize)) {
            for ((x, sums), weights) in (shift..).zip(sums.chunks_exact_mut(channels)).zip(&weights) {
                sums.fill(0.0);
                for (from, weight) in neighbours(x, weights, self.reach) {
                    let values = &row[from * channels..][..channels];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
                }
            }
        }
        Some((counters, lost))
    }

    /// Sums the nth of the samples that were traced, whose number is `sample`, along the columns at row `y`.
    fn gather(&self, n: usize, sample: u64, y: u32, lost: &[Lost], sums: &mut [f64]) {
        let place = self.maker.place_in_pixels(sample);
        let weights = place.and_then(|place| self.film.weights((self.window.x, y), place));
        let columns = &self.columns[n * self.size()..];
        sums.fill(0.0);
        for (from, weight) in neighbours(y - self.around.y, &weights.map(|[_, rows]| rows), self.reach) {
            let row = &columns[from * sums.len()..][..sums.len()];
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
        let begin = lost.partition_point(|lost| lost.row() < (sample, y));
        let row = Window { y, height: 1, ..self.window };
        for Lost { id, values } in lost[begin..].iter().take_while(|lost| lost.row() == (sample, y)) {
            if let Some(at) = row.index_of(id.pixel) {
                sums[at * self.channels..][..self.channels].copy_from_slice(values);
            }
        }
    }
}

/// The places around `at`, along one side of those that are kept, that have a weight.
pub fn neighbours(at: u32, weights: &Option<Weights>, reach: u32) -> impl Iterator<Item = (usize, f64)> {
    let weights = weights.unwrap_or_default().into_iter().enumerate();
    let weighty = weights.filter(|(_, weight)| *weight != 0.0);
    weighty.map(move |(i, weight)| (at as usize + i - reach as usize, weight))
}

#[cfg(test)]
mod tests;
