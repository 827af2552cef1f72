//! Flat patches.

use super::block::{Block, Crossing, Rays, lanes, numbers, spread, vector, vectors};
use super::shaft::Plane;
use crate::math::frame::unit;
use crate::math::simd::{F64x4, dot};
use crate::math::{Bounds, DVec3};
use crate::shape::patch::{Outline, Patch};

/// Four patches; missing ones have no normal and are never met.
#[derive(Clone, Debug)]
pub struct Patches {
    centre: [F64x4; 3],
    /// Unit normal along e₁ × e₂.
    normal: [F64x4; 3],
    /// Dual vectors, whose products with p − centre are the patch coordinates x and y.
    dual: [[F64x4; 3]; 2],
    /// Factor of the disk test: 1 where x² + y² must not exceed 1, 0 where it may.
    round: F64x4,
    primitives: F64x4,
}

impl Patches {
    /// Each patch's number, its plane, and the corners of a box around it.
    pub fn outlines(&self) -> impl Iterator<Item = (u32, Plane, Bounds)> {
        self.there().map(|(lane, primitive)| {
            let [centre, n] = [&self.centre, &self.normal].map(|vectors| vector(vectors, lane));
            let [d1, d2] = self.dual.each_ref().map(|vectors| vector(vectors, lane));
            // What is normal to one dual vector is along the edge of the other.
            let edge = |d: DVec3, other: DVec3| other.cross(n) / d.dot(other.cross(n));
            let reach = edge(d1, d2).abs() + edge(d2, d1).abs();
            (primitive, Plane::new(centre, n), (centre - reach, centre + reach))
        })
    }
}

impl Block for Patches {
    type Shape = Patch;

    fn new(items: &[(&Patch, u32)]) -> Self {
        Self {
            centre: vectors(items, 0.0, |p| p.centre),
            normal: vectors(items, 0.0, |p| unit(p.e1.cross(p.e2))),
            dual: [vectors(items, 0.0, |p| p.dual().0), vectors(items, 0.0, |p| p.dual().1)],
            round: lanes(items, 0.0, |p| f64::from(u8::from(p.outline == Outline::Circle))),
            primitives: numbers(items),
        }
    }

    #[inline(always)]
    fn primitives(&self) -> &F64x4 {
        &self.primitives
    }

    #[inline(always)]
    fn spread(&self, lane: usize) -> Self {
        Self {
            centre: spread(&self.centre, lane),
            normal: spread(&self.normal, lane),
            dual: self.dual.each_ref().map(|dual| spread(dual, lane)),
            round: self.round.spread(lane),
            primitives: self.primitives.spread(lane),
        }
    }

    /// The distance along the line at which it meets the plane, and the patch coordinates there.
    #[inline(always)]
    fn cross(&self, Rays { origin, direction, start, end, from }: &Rays) -> Option<Crossing> {
        let relative = [0, 1, 2].map(|axis| self.centre[axis] - origin[axis]);
        let t = dot(self.normal, relative) / dot(self.normal, *direction);
        if (start.below(t) & t.at_most(*end)).bits() == 0 {
            return None;
        }
        let p = [0, 1, 2].map(|axis| t * direction[axis] - relative[axis]);
        let (x, y) = (dot(self.dual[0], p), dot(self.dual[1], p));
        let one = F64x4::splat(1.0);
        // A circle lies within the square of the same coordinates.
        let in_square = x.abs().max(y.abs()).at_most(one);
        let in_circle = (self.round * (x * x + y * y)).at_most(one);
        let met = (in_square & in_circle).without(from.equals(self.primitives));
        Some(Crossing { t, u: x, v: y, primitive: self.primitives, met })
    }
}
