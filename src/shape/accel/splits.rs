//! Thin triangles across the axes, in several boxes each.
//!
//! The box of such a triangle is nearly empty, so most rays that enter it miss the triangle. Before the tree
//! is built it is cut in halves again and again, the box first from which that takes most area, as long as
//! there are pieces to spend (in the spirit of Karras & Aila 2013, "Fast Parallel Construction of
//! High-Quality Bounding Volume Hierarchies", section 4). Every piece leads to the whole triangle, so what is
//! found does not change.

use crate::math::bounds::{NOTHING, around, union};
use crate::math::{Bounds, DVec3};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A box is cut if its area is more than so many times the total area of the boxes around ever smaller pieces
/// of its triangle.
const EMPTY: f64 = 16.0;

/// Most additional pieces, as a fraction of the number of triangles.
const MORE: f64 = 0.5;

/// A part of a triangle.
pub struct Piece {
    outline: Vec<DVec3>,
    /// Number of the triangle that it is a part of.
    pub of: u32,
}

impl Piece {
    /// The corners of the box.
    pub fn bounds(&self) -> Bounds {
        around(self.outline.iter().copied())
    }

    fn area(&self) -> f64 {
        area(self.bounds())
    }

    /// Calls `add` with the corners of the lower half (0) and of the upper (1), divided in the middle of the box across
    /// its longest axis.
    fn halves(&self, mut add: impl FnMut(usize, DVec3)) {
        let (lo, hi) = self.bounds();
        let axis = (hi - lo).max_position();
        let middle = 0.5 * (lo + hi)[axis];
        let inside = |p: DVec3| [p[axis] <= middle, p[axis] >= middle];
        for (i, &a) in self.outline.iter().enumerate() {
            let b = self.outline[(i + 1) % self.outline.len()];
            let (of_a, of_b) = (inside(a), inside(b));
            for half in 0..2 {
                if of_a[half] {
                    add(half, a);
                }
                if of_a[half] != of_b[half] {
                    let mut cut = a + (b - a) * ((middle - a[axis]) / (b[axis] - a[axis]));
                    cut[axis] = middle;
                    add(half, cut);
                }
            }
        }
    }

    /// Keeps the lower half; returns the upper.
    fn halve(&mut self) -> Self {
        let mut outlines: [Vec<DVec3>; 2] =
            std::array::from_fn(|_| Vec::with_capacity(self.outline.len() + 2));
        self.halves(|half, corner| outlines[half].push(corner));
        let [lower, upper] = outlines;
        self.outline = lower;
        Self { outline: upper, of: self.of }
    }

    /// Whether cutting could pay, and how much: what the two halves have less in area.
    fn gain(&self) -> f64 {
        let mut bounds = [NOTHING; 2];
        self.halves(|half, corner| bounds[half] = union(bounds[half], (corner, corner)));
        self.area() - area(bounds[0]) - area(bounds[1])
    }
}

/// Half the area of a box.
fn area((lo, hi): Bounds) -> f64 {
    let d = hi - lo;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// Half the total box area of a triangle that is cut ever finer: the area of its projections along the axes.
fn least_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).abs().element_sum()
}

/// What thin triangles are cut into: one piece of each, and all others.
pub struct Pieces {
    pub first: Vec<Piece>,
    pub others: Vec<Piece>,
}

/// Whether a triangle's box is so empty that it should be cut.
pub fn is_thin(corners: [DVec3; 3]) -> bool {
    area(around(corners)) > EMPTY * least_area(corners)
}

/// Cuts thin triangles, of which there are `count` with others.
pub fn cut(thin: impl IntoIterator<Item = (u32, [DVec3; 3])>, count: usize) -> Pieces {
    // Gains are positive, so their bits are in their order.
    let key = |piece: &Piece, place: usize| (piece.gain().max(0.0).to_bits(), Reverse(place));
    let mut pieces: Vec<Piece> =
        thin.into_iter().map(|(of, corners)| Piece { outline: corners.to_vec(), of }).collect();
    let keys: Vec<_> = pieces.par_iter().enumerate().map(|(i, piece)| key(piece, i)).collect();
    let mut heap = BinaryHeap::from(keys);
    let thin = pieces.len();
    let most = thin + (count as f64 * MORE) as usize;
    while pieces.len() < most {
        let Some((gain, Reverse(place))) = heap.pop() else { break };
        if gain == 0 {
            break;
        }
        let upper = pieces[place].halve();
        heap.push(key(&pieces[place], place));
        heap.push(key(&upper, pieces.len()));
        pieces.push(upper);
    }
    let others = pieces.split_off(thin);
    Pieces { first: pieces, others }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::{direction, uniform};
    use crate::math::{DVec2, warp};
    use rand_pcg::Pcg32;

    #[test]
    fn pieces_cover_thin_triangles_with_less_area() {
        let mut rng = Pcg32::new(21, 1);
        let mut triangle = || {
            let along = direction(&mut rng);
            let at = DVec3::new(uniform(&mut rng), uniform(&mut rng), uniform(&mut rng));
            [at, at + along, at + along + DVec3::splat(0.003)]
        };
        let triangles: Vec<[DVec3; 3]> = (0..200).map(|_| triangle()).collect();
        let numbered = || triangles.iter().enumerate().map(|(i, t)| (i as u32, *t));
        let Pieces { first, others } = cut(numbered().filter(|(_, t)| is_thin(*t)), triangles.len());
        let thin: std::collections::BTreeSet<u32> = first.iter().map(|piece| piece.of).collect();
        assert_eq!(thin.len(), first.len());
        assert_eq!(others.len(), (triangles.len() as f64 * MORE) as usize);
        assert!(thin.len() > 150, "{}", thin.len());
        let pieces: Vec<Piece> = first.into_iter().chain(others).collect();
        let before: f64 = numbered().map(|(of, t)| Piece { outline: t.to_vec(), of }.area()).sum();
        let whole = numbered().filter(|(of, _)| !thin.contains(of));
        let after = whole.map(|(of, t)| Piece { outline: t.to_vec(), of }.area()).sum::<f64>()
            + pieces.iter().map(Piece::area).sum::<f64>();
        assert!(after < 0.8 * before, "{after} {before}");
        for (of, [a, b, c]) in numbered().filter(|(of, _)| thin.contains(of)) {
            for _ in 0..100 {
                let at = warp::triangle(DVec2::new(uniform(&mut rng), uniform(&mut rng)));
                let p = a + (b - a) * at.x + (c - a) * at.y;
                // Cuts and points are rounded in coordinates of about 1.
                let rounding = DVec3::splat(1e-15);
                let holds = |piece: &Piece| {
                    let (lo, hi) = piece.bounds();
                    piece.of == of && (p + rounding).cmpge(lo).all() && (p - rounding).cmple(hi).all()
                };
                assert!(pieces.iter().any(holds), "{p} of {of}");
            }
        }
    }

    #[test]
    fn well_shaped_triangles_stay_whole() {
        let mut rng = Pcg32::new(22, 1);
        let mut direction = || direction(&mut rng);
        for _ in 0..1000 {
            let frame = crate::math::Frame::about(direction());
            let corner = |i: u32| {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU / 3.0 * i as f64);
                frame.to_world(DVec3::new(sin, cos, 0.0))
            };
            assert!(!is_thin([0, 1, 2].map(corner)));
        }
    }
}
