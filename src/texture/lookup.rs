//! How the values of an image or a grid are looked up between its cells and beyond them.

use crate::scene::error::SceneError;
use crate::scene::params::Params;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

/// The parameters `filter_type` and `wrap_mode`.
#[derive(Clone, Copy, Debug)]
pub struct Lookup {
    /// The value of the cell that a place is in, not a mean of those about it.
    pub nearest: bool,
    wrap: Wrap,
}

impl Lookup {
    #[cfg(test)]
    pub fn repeated(nearest: bool) -> Self {
        Self { nearest, wrap: Wrap::Repeat }
    }

    /// `filters` and `wraps` are the words for them, the defaults first; `beyond` is what wrapping is about.
    pub fn parse(
        params: &mut Params,
        filters: [&'static str; 2],
        wraps: [&'static str; 3],
        beyond: &'static str,
    ) -> Result<Self, SceneError> {
        let nearest = params.choice("filter_type", &filters, "between cells")? == "nearest";
        let wrap = match params.choice("wrap_mode", &wraps, beyond)? {
            "mirror" => Wrap::Mirror,
            "clamp" => Wrap::Clamp,
            _ => Wrap::Repeat,
        };
        Ok(Self { nearest, wrap })
    }

    /// Along one axis of `size` cells that fill [0, 1], the two about a place, and the distance from the
    /// first, in cells; zero if that alone counts.
    #[inline(always)]
    pub fn between(&self, p: f64, size: usize) -> ([usize; 2], f64) {
        // Nearly all cells are inside then; `beyond`, which divides, is only for those on the border.
        let p = if self.wrap == Wrap::Repeat { p - p.floor() } else { p };
        let x = p * size as f64 - if self.nearest { 0.0 } else { 0.5 };
        let first = x.floor();
        let wrapped = |i: i64| if (0..size as i64).contains(&i) { i as usize } else { self.beyond(i, size) };
        // Of a place beyond all numbers there is none.
        let distance = if !self.nearest && x - first < 1.0 { x - first } else { 0.0 };
        ([wrapped(first as i64), wrapped((first as i64).saturating_add(1))], distance)
    }

    /// The cells, each perhaps several times, that stand for those from `first` to `last`.
    pub fn range(&self, first: f64, last: f64, size: usize) -> impl Iterator<Item = usize> {
        let most = size as f64;
        let (first, last) = match self.wrap {
            Wrap::Clamp => (first.clamp(0.0, most - 1.0), last.clamp(0.0, most - 1.0)),
            // Two grids hold all that there is.
            Wrap::Repeat | Wrap::Mirror => (first, last.min(first + 2.0 * most)),
        };
        (first as i64..=last as i64).map(move |i| self.beyond(i, size))
    }

    /// The cell that is used for one outside.
    #[cold]
    fn beyond(&self, i: i64, size: usize) -> usize {
        let n = size as i64;
        match self.wrap {
            Wrap::Repeat => i.rem_euclid(n) as usize,
            Wrap::Clamp => i.clamp(0, n - 1) as usize,
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * n);
                (if j < n { j } else { 2 * n - 1 - j }) as usize
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_beyond_all_numbers_have_cells_too() {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            for p in [1e300, -1e300, f64::MAX, f64::MIN] {
                let (cells, distance) = Lookup { nearest: false, wrap }.between(p, 16);
                assert!(
                    cells.iter().all(|cell| *cell < 16) && (0.0..1.0).contains(&distance),
                    "{wrap:?} {p}"
                );
            }
        }
    }
}
