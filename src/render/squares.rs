//! Squares of the film, which cut a window into parts.

use crate::film::Window;
use serde::{Deserialize, Serialize};

/// Those squares of an edge, out of all that the film is divided into, that a window has pixels of, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Squares {
    /// Of the edge, which is a power of two.
    log_edge: u32,
    /// Column and row of the first, in squares of the film.
    first: (u32, u32),
    columns: u32,
    rows: u32,
}

impl Squares {
    /// The edge must be a power of two.
    pub fn of(window: Window, edge: u32) -> Self {
        let along = |begin: u32, size: u32| (begin / edge, (begin + size).div_ceil(edge) - begin / edge);
        let ((x, columns), (y, rows)) = (along(window.x, window.width), along(window.y, window.height));
        Self { log_edge: edge.ilog2(), first: (x, y), columns, rows }
    }

    pub fn edge(&self) -> u32 {
        1 << self.log_edge
    }

    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// The number of the square that a pixel of the window lies in.
    #[inline]
    pub fn index_of(&self, (x, y): (u32, u32)) -> usize {
        let (column, row) = ((x >> self.log_edge) - self.first.0, (y >> self.log_edge) - self.first.1);
        row as usize * self.columns as usize + column as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_square_of_the_film() {
        let window = Window { x: 13, y: 6, width: 30, height: 11 };
        for edge in [1, 2, 8, 16] {
            let squares = Squares::of(window, edge);
            let mut pixels = vec![vec![]; squares.count()];
            (0..window.pixels()).map(|i| window.pixel(i)).for_each(|p| pixels[squares.index_of(p)].push(p));
            for together in pixels {
                let places: Vec<_> = together.iter().map(|(x, y)| (x / edge, y / edge)).collect();
                assert!(!places.is_empty() && places.iter().all(|place| *place == places[0]), "{edge}");
            }
        }
    }
}
