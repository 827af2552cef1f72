//! The cells of a film that looks are taken at, in an order that all looks share.
//!
//! Light paths may make all their noise in a small part of the film. Cells spread evenly may miss that part,
//! and a pilot would not see that more light paths pay. So the cells are drawn from two strata. Of every
//! beginning of the order at least a quarter are *noisy*, if there are so many, and means over the film
//! weight either stratum by its share of the film.

use super::scattered;
use crate::film::Window;
use crate::integrator::path::reuse::CELL;

/// Most cells that a look goes on to.
const MOST: u64 = 64;

/// One in this many cells is a noisy one at least.
const NOISY: usize = 4;

/// Cells to look at.
pub struct Cells {
    order: Vec<Place>,
    /// The share of the film's cells that are noisy.
    noisy: f64,
}

/// A cell.
#[derive(Clone, Copy)]
struct Place {
    corner: (u32, u32),
    noisy: bool,
}

impl Cells {
    /// Of a film; `is_noisy` is asked of the first pixel of each cell within it.
    pub fn of(film: Window, is_noisy: impl Fn((u32, u32)) -> bool) -> Self {
        let (left, top) = (film.x / CELL, film.y / CELL);
        let columns = (film.x + film.width).div_ceil(CELL) - left;
        let rows = (film.y + film.height).div_ceil(CELL) - top;
        let all = u64::from(columns) * u64::from(rows);
        let place = |i: u64| {
            let corner = ((left + i as u32 % columns) * CELL, (top + i as u32 / columns) * CELL);
            Place { corner, noisy: is_noisy(first_of(corner, film)) }
        };
        let noisy: Vec<u64> = (0..all).filter(|i| place(*i).noisy).collect();
        let mut evenly: Vec<u64> = (0..all.min(MOST)).collect();
        if all > MOST {
            evenly = evenly.into_iter().map(|i| scattered(i, all)).collect();
        } else {
            evenly.sort_by_key(|i| scattered(*i, u64::MAX));
        }
        let mut more = (0..MOST).filter_map(|i| noisy.get(scattered(i, noisy.len() as u64) as usize));
        let (mut order, mut found): (Vec<u64>, usize) = (vec![], 0);
        for next in evenly {
            let mut push = |i: u64| {
                if order.len() < MOST as usize && !order.contains(&i) {
                    order.push(i);
                    found += usize::from(place(i).noisy);
                }
                (found * NOISY, order.len())
            };
            let (mut enough, mut taken) = push(next);
            while enough < taken {
                let Some(i) = more.next() else { break };
                (enough, taken) = push(*i);
            }
        }
        Self { order: order.into_iter().map(place).collect(), noisy: noisy.len() as f64 / all as f64 }
    }

    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// The corners of the first so many cells.
    pub fn corners(&self, count: usize) -> impl ExactSizeIterator<Item = (u32, u32)> {
        self.order[..count.min(self.len())].iter().map(|place| place.corner)
    }

    /// The weight of each of the first so many cells in a mean over the film.
    pub fn weights(&self, count: usize) -> impl Iterator<Item = f64> {
        let begin = &self.order[..count.min(self.len())];
        let noisy = begin.iter().filter(|place| place.noisy).count();
        let even = begin.len() - noisy;
        // A stratum of which nothing is seen is taken for the other.
        let one_only = noisy == 0 || even == 0;
        let weight = move |place: &Place| match place.noisy {
            _ if one_only => 1.0 / (noisy + even) as f64,
            true => self.noisy / noisy as f64,
            false => (1.0 - self.noisy) / even as f64,
        };
        begin.iter().map(weight)
    }
}

/// The first pixel of a cell that lies within a film that it overlaps.
pub fn first_of(corner: (u32, u32), film: Window) -> (u32, u32) {
    (corner.0.max(film.x), corner.1.max(film.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn film(width: u32, height: u32) -> Window {
        Window { x: 0, y: 0, width, height }
    }

    #[test]
    fn every_beginning_lies_all_over_the_film() {
        for (width, height, count) in [(64, 64, 64), (60, 44, 48), (1920, 1080, 64)] {
            let cells = Cells::of(film(width, height), |_| false);
            let quarter = |(x, y): (u32, u32)| (2 * x >= width, 2 * y >= height);
            assert_eq!(cells.corners(8).map(quarter).collect::<BTreeSet<_>>().len(), 4);
            assert_eq!(cells.corners(100).collect::<BTreeSet<_>>().len(), count, "{width} x {height}");
            assert!(cells.weights(8).all(|weight| weight == 0.125));
        }
    }

    #[test]
    fn noisy_cells_are_a_quarter_however_small_their_part_is() {
        // 100 of 32 400 cells.
        let is_noisy = |(x, y): (u32, u32)| x < 80 && y < 80;
        let cells = Cells::of(film(1920, 1080), is_noisy);
        for count in [8, 16, 32, 64] {
            let places: Vec<_> = cells.corners(count).collect();
            assert_eq!(places.iter().filter(|place| is_noisy(**place)).count() * 4, count);
            assert_eq!(places.iter().collect::<BTreeSet<_>>().len(), count);
            let weights: Vec<_> = cells.weights(count).collect();
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let noisy = places.iter().zip(&weights).filter(|(place, _)| is_noisy(**place));
            let share: f64 = noisy.map(|(_, weight)| weight).sum();
            assert!((share - 100.0 / 32_400.0).abs() < 1e-12, "{share}");
        }
        // One cell cannot be a quarter.
        let cells = Cells::of(film(1920, 1080), |place| place == (800, 800));
        assert_eq!((cells.len(), cells.corners(64).filter(|place| *place == (800, 800)).count()), (64, 1));
    }

    #[test]
    fn where_all_cells_are_seen_all_weigh_the_same() {
        let cells = Cells::of(film(60, 44), |(x, _)| x < 16);
        assert_eq!(cells.len(), 48);
        assert!(cells.weights(48).all(|weight| (weight * 48.0 - 1.0).abs() < 1e-12));
    }
}
