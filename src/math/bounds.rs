//! Boxes along the axes, by their corners.

use super::DVec3;
use glam::BVec3;

/// The corner with the least and that with the greatest coordinates.
pub type Bounds = (DVec3, DVec3);

/// The box around nothing: its union with another box is that box.
pub const NOTHING: Bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);

/// The box around points.
#[inline]
pub fn around(points: impl IntoIterator<Item = DVec3>) -> Bounds {
    points.into_iter().fold(NOTHING, |(lo, hi), p| (lo.min(p), hi.max(p)))
}

/// The box around two boxes.
#[inline]
pub fn union(a: Bounds, b: Bounds) -> Bounds {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Half of a box's longest side; no corner is too far away for it.
pub fn half_extent((lo, hi): Bounds) -> f64 {
    (0.5 * hi - 0.5 * lo).max_element()
}

/// All eight corners of a box.
pub fn corners((lo, hi): Bounds) -> [DVec3; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|i: u32| DVec3::select(BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), hi, lo))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_hold_their_points_and_no_more() {
        let points = [DVec3::new(1.0, -2.0, 3.0), DVec3::new(-1.0, 5.0, 0.5), DVec3::ZERO];
        let (first, rest) = (around(points[..1].iter().copied()), around(points[1..].iter().copied()));
        assert_eq!(first, (points[0], points[0]));
        assert_eq!(around(points), (DVec3::new(-1.0, -2.0, 0.0), DVec3::new(1.0, 5.0, 3.0)));
        assert_eq!(union(first, rest), around(points));
        assert_eq!(union(NOTHING, rest), rest);
        assert_eq!(around(corners(rest)), rest);
        assert!((0..8).all(|i| (0..i).all(|j| corners(rest)[i] != corners(rest)[j])));
    }
}
