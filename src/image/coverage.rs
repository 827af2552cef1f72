//! Whether boxes in (column, row, sample) fill the box around them.

use super::merge::refusal;
use super::{ImageError, Window};
use std::ops::Range;
use std::path::Path;

/// The box that one image covers.
pub(super) struct Part<'a> {
    pub(super) path: &'a Path,
    pub(super) window: Window,
    pub(super) samples: Range<u64>,
}

impl Part<'_> {
    /// The ranges of rows, columns and samples.
    fn sides(&self) -> [Range<u64>; 3] {
        let Window { x, y, width, height } = self.window;
        let side = |start: u32, length: u32| u64::from(start)..u64::from(start) + u64::from(length);
        [side(y, height), side(x, width), self.samples.clone()]
    }
}

/// The window and the sample range that the parts make up together.
///
/// # Errors
/// If two parts overlap, or if something is missing: the first row, then column, then sample that is.
pub(super) fn check_coverage(parts: &[Part]) -> Result<(Window, Range<u64>), ImageError> {
    for (i, a) in parts.iter().enumerate() {
        for b in &parts[..i] {
            let meets = |(p, q): (Range<u64>, Range<u64>)| p.start < q.end && q.start < p.end;
            if a.sides().into_iter().zip(b.sides()).all(meets) {
                return Err(refusal(b.path, a.path, "they hold the same samples of the same pixels"));
            }
        }
    }
    let boxes: Vec<[Range<u64>; 3]> = parts.iter().map(Part::sides).collect();
    let hull = |axis: usize| {
        let start = boxes.iter().map(|sides| sides[axis].start).min().unwrap_or(0);
        start..boxes.iter().map(|sides| sides[axis].end).max().unwrap_or(start)
    };
    let bounds = [hull(0), hull(1), hull(2)];
    let [rows, columns, samples] = bounds.clone();
    if let Some([row, column, gap]) = first_gap(&boxes.iter().collect::<Vec<_>>(), &bounds) {
        let (x, y) = (column.start, row.start);
        let cause = if gap == samples {
            format!("no file covers pixel ({x}, {y})")
        } else {
            format!("samples {gap:?} of pixel ({x}, {y}) are missing")
        };
        return Err(ImageError::new(cause));
    }
    let length = |range: &Range<u64>| (range.end - range.start) as u32;
    let (width, height) = (length(&columns), length(&rows));
    Ok((Window { x: columns.start as u32, y: rows.start as u32, width, height }, samples))
}

/// The first range of samples, and the first column and row that lack it, which the boxes leave open.
///
/// Along the rows, the set of boxes changes only where one begins or ends. Within a slab between two such
/// rows the question is the same with one axis less.
fn first_gap(boxes: &[&[Range<u64>; 3]], bounds: &[Range<u64>; 3]) -> Option<[Range<u64>; 3]> {
    let slabs = |axis: usize, boxes: &[&[Range<u64>; 3]]| {
        let mut borders = vec![bounds[axis].start, bounds[axis].end];
        borders.extend(boxes.iter().flat_map(|sides| [sides[axis].start, sides[axis].end]));
        borders.sort_unstable();
        borders.dedup();
        borders.windows(2).map(|ends| ends[0]..ends[1]).collect::<Vec<_>>()
    };
    for row in slabs(0, boxes) {
        let here: Vec<_> = boxes.iter().copied().filter(|sides| sides[0].contains(&row.start)).collect();
        for column in slabs(1, &here) {
            let mut samples: Vec<_> =
                here.iter().filter(|sides| sides[1].contains(&column.start)).map(|sides| &sides[2]).collect();
            samples.sort_unstable_by_key(|range| range.start);
            let mut covered = bounds[2].start;
            for range in samples {
                if range.start > covered {
                    return Some([row, column, covered..range.start]);
                }
                covered = range.end;
            }
            if covered < bounds[2].end {
                return Some([row, column, covered..bounds[2].end]);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(parts: &[(u32, u32, u32, u32, Range<u64>)]) -> Result<(Window, Range<u64>), String> {
        let part = |(x, y, width, height, samples): &(u32, u32, u32, u32, Range<u64>)| {
            let window = Window { x: *x, y: *y, width: *width, height: *height };
            Part { path: Path::new("a.exr"), window, samples: samples.clone() }
        };
        check_coverage(&parts.iter().map(part).collect::<Vec<_>>()).map_err(|error| error.to_string())
    }

    #[test]
    fn divisions_may_differ_between_sample_ranges() {
        let parts = [
            (2, 3, 4, 1, 0..4),
            (2, 4, 4, 1, 0..4),
            (2, 3, 1, 2, 4..8),
            (3, 3, 3, 2, 4..8),
            (2, 3, 4, 2, 8..9),
        ];
        assert_eq!(check(&parts), Ok((Window { x: 2, y: 3, width: 4, height: 2 }, 0..9)));
    }

    #[test]
    fn gaps_are_named() {
        assert_eq!(
            check(&[(0, 0, 2, 2, 0..4), (0, 0, 2, 2, 8..12)]),
            Err("samples 4..8 of pixel (0, 0) are missing".into())
        );
        assert_eq!(
            check(&[(0, 0, 2, 2, 0..4), (2, 1, 2, 1, 0..4)]),
            Err("no file covers pixel (2, 0)".into())
        );
        assert_eq!(
            check(&[(0, 1, 2, 2, 0..4), (2, 0, 2, 3, 0..4)]),
            Err("no file covers pixel (0, 0)".into())
        );
        assert_eq!(
            check(&[(0, 0, 4, 2, 0..4), (0, 0, 2, 2, 4..8), (3, 0, 1, 2, 4..8)]),
            Err("samples 4..8 of pixel (2, 0) are missing".into())
        );
    }

    #[test]
    fn overlaps_are_refused() {
        let overlap = check(&[(0, 0, 2, 2, 0..8), (1, 1, 2, 2, 4..12)]);
        assert!(overlap.is_err_and(|error| error.contains("the same samples of the same pixels")));
    }
}
