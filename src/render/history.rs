//! What an image had come to after certain numbers of samples.
//!
//! Differences between these sums are those of batches of samples, whose scatter tells how well the image's mean is
//! known (method of batch means, [`super::law`]). They are kept for squares of the film that are large enough for
//! errors of one to know nothing of those of another, where paths are shared or not. A sum is read from exact ones,
//! so it is a function of the samples that it is a sum of, however they came together.

use super::TILE;
use super::quality::Correlation;
use super::squares::Squares;
use crate::film::{BLOCK, ChannelAccumulator, ExactSum, Window};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;

/// Squares are enlarged until there are no more of them than this, or until they are tiles.
const FEW: usize = 1024;

/// Most batches whose sums are kept: four tell a variance and how it falls.
const BATCHES: u64 = 8;

/// Where samples count for several pixels, errors may be alike all over the image, and what a batch says of that is
/// a single number.
const BATCHES_OF_SPREAD: u64 = 32;

/// Sums of squares after numbers of samples: all multiples of a length, which is a power of two of [`BLOCK`]s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct History {
    squares: Squares,
    batches: u64,
    /// The number of the first sample.
    start: u64,
    length: u64,
    /// By the number of the sample that is not in them any more.
    sums: BTreeMap<u64, Vec<Sum>>,
}

/// A sum over samples and over the pixels of a square, of the first three channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Sum(#[serde(with = "super::bits")] [f64; 3]);

impl History {
    /// Of a window without samples, the first of which will have the number `start`; `None` of independent ones that
    /// count for one pixel each: the variances of pixels tell all that there is to know of their sum.
    pub fn of(scene: &Scene, window: Window, start: u64) -> Option<Self> {
        let correlation = Correlation::of(scene);
        let more_to_know = scene.sensor.sampler.kind.stratifies() || correlation != Correlation::NONE;
        more_to_know.then(|| Self::new(window, correlation, start))
    }

    pub(super) fn new(window: Window, correlation: Correlation, start: u64) -> Self {
        let mut edge = correlation.edge;
        while edge < TILE && Squares::of(window, edge).count() > FEW {
            edge *= 2;
        }
        let batches = if correlation.gain > 1.0 { BATCHES_OF_SPREAD } else { BATCHES };
        let squares = Squares::of(window, edge);
        let sums = BTreeMap::from([(start, vec![Sum::default(); squares.count()])]);
        Self { squares, batches, start, length: BLOCK, sums }
    }

    /// The same where it is known that samples up to `end` will come: fewer sums are wanted on the way.
    pub fn until(mut self, end: u64) -> Self {
        self.lengthen(end);
        self
    }

    /// Batches long enough for samples up to `end`.
    fn lengthen(&mut self, end: u64) {
        let length = self.length_at(end);
        if length > self.length {
            self.length = length;
            self.sums.retain(|number, _| number.is_multiple_of(length));
        }
    }

    /// Edge of the squares, in pixels.
    pub fn edge(&self) -> u32 {
        self.squares.edge()
    }

    /// The length of batches when all samples up to `end` have come.
    fn length_at(&self, end: u64) -> u64 {
        let mut length = self.length;
        while (end - self.start).div_ceil(length) > self.batches {
            length *= 2;
        }
        length
    }

    /// How many samples may be added at once after `done`, so that no number is passed which sums are wanted of.
    pub fn longest_step(&self, done: u64) -> u64 {
        self.length_at(done + 1)
    }

    /// Notes what pixels have come to, if it is wanted: the exact sums of all samples before `done`, row by row of the
    /// window.
    pub fn note(&mut self, done: u64, window: Window, sums: &[ChannelAccumulator]) {
        self.lengthen(done);
        if let Some(mut notes) = self.notes(window, done..done + 1) {
            notes.add(done, sums);
            self.take(&notes);
        }
    }

    /// An empty leaf for a part of the window whose borders cut no square, and for all numbers in a range at which sums
    /// are wanted; `None` if there is none.
    pub fn notes(&self, part: Window, numbers: Range<u64>) -> Option<Notes> {
        let length = self.length;
        let (first, end) = (numbers.start.div_ceil(length).max(1), numbers.end.div_ceil(length));
        let terms = u64::from(self.edge() * self.edge()) * ((numbers.end - self.start) / BLOCK);
        let squares = Squares::of(part, self.squares.edge());
        let exact = vec![vec![[ExactSum::default(); 3]; squares.count()]; end.saturating_sub(first) as usize];
        (!exact.is_empty() && terms <= ExactSum::MOST_TERMS).then_some(Notes {
            part,
            squares,
            length,
            first,
            exact,
        })
    }

    /// Takes over what has been noted of a part.
    pub fn take(&mut self, notes: &Notes) {
        for (number, exact) in (notes.first..).zip(&notes.exact) {
            let count = self.squares.count();
            let sums = self.sums.entry(number * notes.length).or_insert_with(|| vec![Sum::default(); count]);
            for square in notes.part.tiles(self.squares.edge()) {
                let pixel = (square.x, square.y);
                let exact = &exact[notes.squares.index_of(pixel)];
                sums[self.squares.index_of(pixel)] = Sum(std::array::from_fn(|c| exact[c].value()));
            }
        }
    }

    /// The mean of each square over a range of samples, as a sum over its pixels; `None` where one of the range's ends
    /// has not been noted.
    pub fn means(&self, range: Range<u64>) -> Option<Vec<[f64; 3]>> {
        let (before, after) = (self.sums.get(&range.start)?, self.sums.get(&range.end)?);
        let count = (range.end - range.start) as f64;
        let mean =
            |(Sum(before), Sum(after)): (&Sum, &Sum)| std::array::from_fn(|c| (after[c] - before[c]) / count);
        Some(before.iter().zip(after).map(mean).collect())
    }

    /// Samples of a batch.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// All batches that have been noted whole.
    pub fn batches(&self) -> impl Iterator<Item = Range<u64>> + '_ {
        let noted = |number: &u64| self.sums.contains_key(&(number + self.length));
        self.sums.keys().copied().filter(noted).map(|number| number..number + self.length)
    }
}

/// What a part of a window comes to.
pub struct Notes {
    part: Window,
    squares: Squares,
    /// Numbers are multiples of this, which is a power of two,
    length: u64,
    /// beginning with so many of it.
    first: u64,
    exact: Vec<Vec<[ExactSum; 3]>>,
}

impl Notes {
    /// Samples in ranges, after each of which sums are wanted.
    pub fn ranges(&self, samples: &Range<u64>) -> Vec<Range<u64>> {
        let (length, end) = (self.length, samples.end);
        let from = |begin: u64| (begin < end).then(|| begin..end.min((begin / length + 1) * length));
        std::iter::successors(from(samples.start), |last| from(last.end)).collect()
    }

    /// Adds the exact sums of all samples before `done`, pixel by pixel of the part, if they are wanted.
    pub fn add(&mut self, done: u64, sums: &[ChannelAccumulator]) {
        let (part, number) = (self.part, done / self.length);
        if !done.is_multiple_of(self.length) {
            return;
        }
        let exact = &mut self.exact[(number - self.first) as usize];
        let channels = sums.len() / part.pixels();
        for (y, row) in (part.y..).zip(sums.chunks_exact(channels * part.width as usize)) {
            for (x, pixel) in (part.x..).zip(row.chunks_exact(channels)) {
                let square = &mut exact[self.squares.index_of((x, y))];
                square.iter_mut().zip(pixel).for_each(|(sum, channel)| channel.add_blocks_to(sum));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Accumulators;

    const WINDOW: Window = Window { x: 5, y: 14, width: 21, height: 9 };

    /// Two channels of pixels, each sample of which is a number of its own.
    fn add(sums: &mut Accumulators, samples: Range<u64>) {
        for (i, pixel) in (0..WINDOW.pixels()).zip(sums.all_mut().chunks_exact_mut(2)) {
            for number in samples.clone() {
                pixel[0].add(number, 1.0 / (1 + i as u64 * 7 + number) as f64);
                pixel[1].add(number, number as f64);
            }
        }
    }

    /// By steps of a block, by the longest that are allowed, and tile by tile; known beforehand how many, or not.
    #[test]
    fn what_is_noted_does_not_depend_on_the_way() {
        for (edge, gain, samples) in [(1, 1.0, 0..64), (8, 1.0, 0..100), (4, 2.0, 0..1000), (2, 1.0, 12..142)]
        {
            let open = || History::new(WINDOW, Correlation { edge, gain }, samples.start);
            let new = || open().until(samples.end);
            let by_steps = |mut history: History, longest: u64| {
                let (mut sums, mut done) = (Accumulators::new(21, 9, 2), samples.start);
                while done < samples.end {
                    let step = history.longest_step(done).min(longest);
                    let end = samples.end.min((done / step + 1) * step);
                    add(&mut sums, done..end);
                    history.note(end, WINDOW, sums.all());
                    done = end;
                }
                history
            };
            let whole = by_steps(new(), u64::MAX);
            for other in [by_steps(new(), BLOCK), by_steps(open(), u64::MAX), by_steps(open(), BLOCK)] {
                assert_eq!(other, whole);
            }
            let mut parts = new();
            for tile in WINDOW.tiles(TILE) {
                let mut notes =
                    parts.notes(tile, samples.start + 1..samples.end + 1).expect("some are wanted");
                let mut sums = Accumulators::new(21, 9, 2);
                for range in notes.ranges(&samples) {
                    add(&mut sums, range.clone());
                    let pixel = |(x, y): (u32, u32)| sums.pixel(x - WINDOW.x, y - WINDOW.y);
                    let own: Vec<_> =
                        (0..tile.pixels()).flat_map(|i| pixel(tile.pixel(i))).copied().collect();
                    notes.add(range.end, &own);
                }
                parts.take(&notes);
            }
            assert_eq!(parts, whole);
            let lengths: Vec<_> = whole.batches().map(|batch| batch.end - batch.start).collect();
            assert!(lengths.len() > 2 && lengths.iter().all(|length| *length == whole.length), "{lengths:?}");
            assert!((samples.end - samples.start).div_ceil(whole.length) <= whole.batches);
        }
    }

    #[test]
    fn means_are_those_of_a_batch() {
        let mut history = History::new(WINDOW, Correlation { edge: 16, gain: 1.0 }, 0);
        let mut sums = Accumulators::new(21, 9, 2);
        for begin in [0, 4, 8] {
            add(&mut sums, begin..begin + 4);
            history.note(begin + 4, WINDOW, sums.all());
        }
        // Squares at columns 0, 16 and rows 0, 16, of which the window has so many pixels.
        let pixels = [11 * 2, 10 * 2, 11 * 7, 10 * 7];
        let means = history.means(4..12).expect("they are noted");
        for (mean, pixels) in means.iter().zip(pixels) {
            assert_eq!((mean[1], mean[2]), (7.5 * f64::from(pixels), 0.0));
        }
        assert_eq!((means.len(), history.means(2..4)), (4, None));
    }

    #[test]
    fn large_films_have_few_squares_or_those_of_tiles() {
        let edge = |width, height, edge| {
            let correlation = Correlation { edge, gain: 1.0 };
            History::new(Window { x: 0, y: 0, width, height }, correlation, 0).edge()
        };
        assert_eq!([edge(40, 40, 1), edge(96, 72, 1), edge(96, 72, 8), edge(4000, 3000, 1)], [2, 4, 8, TILE]);
    }
}
