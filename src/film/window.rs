//! Rectangles of pixels.

/// A rectangle of pixels within the film; `x`, `y` is its upper left pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Window {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Window {
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Column and row, counted on the film, of the pixel with this index, row by row of the window.
    pub fn pixel(&self, index: usize) -> (u32, u32) {
        (self.x + index as u32 % self.width, self.y + index as u32 / self.width)
    }

    /// The inverse of [`pixel`](Self::pixel); `None` of a pixel that is not in the window.
    #[inline(always)]
    pub fn index_of(&self, (x, y): (u32, u32)) -> Option<usize> {
        let (x, y) = (x.wrapping_sub(self.x), y.wrapping_sub(self.y));
        (x < self.width && y < self.height).then(|| (y * self.width + x) as usize)
    }

    /// Whether another window lies within this one, even if its far corner is beyond all numbers.
    pub fn encloses(&self, other: &Self) -> bool {
        let end = |begin: u32, size: u32| u64::from(begin) + u64::from(size);
        self.x <= other.x
            && self.y <= other.y
            && end(other.x, other.width) <= end(self.x, self.width)
            && end(other.y, other.height) <= end(self.y, self.height)
    }

    /// The window with `reach` pixels more on each side, as far as they are within another that encloses it.
    pub fn grown_within(&self, reach: u32, outer: &Self) -> Self {
        let grow = |begin: u32, size: u32, first: u32, all: u32| {
            let low = begin.saturating_sub(reach).max(first);
            let high = (begin + size + reach).min(first + all);
            (low, high - low)
        };
        let (x, width) = grow(self.x, self.width, outer.x, outer.width);
        let (y, height) = grow(self.y, self.height, outer.y, outer.height);
        Self { x, y, width, height }
    }

    /// The window's parts in the squares of this edge that the film is divided into, row by row. Windows that
    /// are cut in this way share no square but along their borders.
    pub fn tiles(self, edge: u32) -> impl Iterator<Item = Self> {
        self.bands(edge).flat_map(move |band| {
            cut(band.x, band.width, edge).map(move |(x, width)| Self { x, width, ..band })
        })
    }

    /// The window's parts in the bands of so many rows that the film is divided into, from the top.
    pub fn bands(self, rows: u32) -> impl Iterator<Item = Self> {
        cut(self.y, self.height, rows).map(move |(y, height)| Self { y, height, ..self })
    }
}

/// Cuts so many pixels in a row at multiples of `edge` on the film: where each piece begins, and how long it
/// is.
fn cut(begin: u32, size: u32, edge: u32) -> impl Iterator<Item = (u32, u32)> {
    (begin / edge * edge..begin + size).step_by(edge as usize).map(move |at| {
        let first = at.max(begin);
        (first, (at + edge).min(begin + size) - first)
    })
}

#[cfg(test)]
mod tests {
    use super::Window;

    const WINDOW: Window = Window { x: 5, y: 30, width: 40, height: 21 };

    #[test]
    fn tiles_and_bands_hold_each_pixel_once_and_cross_no_multiple_of_their_edge() {
        for parts in [WINDOW.tiles(16).collect::<Vec<_>>(), WINDOW.bands(16).collect()] {
            let mut times = vec![0; WINDOW.pixels()];
            for part in parts {
                assert!(part.height <= 16 && part.y / 16 == (part.y + part.height - 1) / 16, "{part:?}");
                for i in 0..part.pixels() {
                    times[WINDOW.index_of(part.pixel(i)).expect("it is of the window")] += 1;
                }
            }
            assert!(times.iter().all(|times| *times == 1));
        }
        assert!(WINDOW.tiles(16).all(|tile| tile.x / 16 == (tile.x + tile.width - 1) / 16));
    }

    #[test]
    fn pixels_outside_have_no_index() {
        let outside = [(4, 30), (45, 30), (5, 29), (5, 51), (u32::MAX, u32::MAX)];
        assert!(outside.iter().all(|pixel| WINDOW.index_of(*pixel).is_none()));
    }

    #[test]
    fn windows_grow_as_far_as_the_outer_one_and_are_enclosed_by_it() {
        let outer = Window { x: 3, y: 30, width: 60, height: 40 };
        let grown = WINDOW.grown_within(4, &outer);
        assert_eq!(grown, Window { x: 3, y: 30, width: 46, height: 25 });
        assert!(outer.encloses(&grown) && grown.encloses(&WINDOW) && !WINDOW.encloses(&grown));
        assert!(!outer.encloses(&Window { width: u32::MAX, ..WINDOW }));
    }
}
