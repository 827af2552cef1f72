//! Open cylinders.

use super::block::{Block, Crossing, Rays, lanes, numbers, spread, vector, vectors};
use crate::math::Bounds;
use crate::math::simd::{F64x4, dot};
use crate::shape::Cylinder;
use crate::shape::cylinder::bounds;

/// Four cylinders; missing ones have a length that no point lies along.
#[derive(Clone, Debug)]
pub struct Cylinders {
    start: [F64x4; 3],
    /// Unit vectors along the axes.
    axis: [F64x4; 3],
    length: F64x4,
    radius: F64x4,
    primitives: F64x4,
}

impl Cylinders {
    /// The corners of a box around each.
    pub fn bounds(&self) -> impl Iterator<Item = Bounds> {
        self.there().map(|(lane, _)| {
            let (start, axis) = (vector(&self.start, lane), vector(&self.axis, lane));
            bounds(start, axis, self.length.lane(lane), self.radius.lane(lane))
        })
    }
}

impl Block for Cylinders {
    type Shape = Cylinder;

    fn new(items: &[(&Cylinder, u32)]) -> Self {
        Self {
            start: vectors(items, 0.0, |c| c.start),
            axis: vectors(items, 0.0, |c| c.axis),
            length: lanes(items, f64::NAN, |c| c.length),
            radius: lanes(items, 0.0, |c| c.radius),
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
            start: spread(&self.start, lane),
            axis: spread(&self.axis, lane),
            length: self.length.spread(lane),
            radius: self.radius.spread(lane),
            primitives: self.primitives.spread(lane),
        }
    }

    /// The nearest crossing of a line and a cylinder beyond `start`.
    ///
    /// The sphere's equation in the plane across the axis, in which the direction has the length √a; of a
    /// line along the axis a is 0 and nothing compares. A ray that starts on the cylinder has its first root
    /// at 0 exactly, so the other is −2b/a.
    #[inline(always)]
    fn cross(&self, Rays { origin, direction, start, from, .. }: &Rays) -> Option<Crossing> {
        let (zero, axis, radius) = (F64x4::splat(0.0), &self.axis, self.radius);
        let from = from.equals(self.primitives);
        let o = [0, 1, 2].map(|i| origin[i] - self.start[i]);
        let (along_o, along_d) = (dot(o, *axis), dot(*direction, *axis));
        let o_across = [0, 1, 2].map(|i| o[i] - axis[i] * along_o);
        let d_across = [0, 1, 2].map(|i| direction[i] - axis[i] * along_d);
        let a = dot(d_across, d_across);
        let b = dot(o_across, d_across);
        let to_nearest = b / a;
        let nearest = [0, 1, 2].map(|i| o_across[i] - d_across[i] * to_nearest);
        let discriminant = a * (radius * radius - dot(nearest, nearest));
        let met = zero.at_most(discriminant) | from;
        if met.bits() == 0 {
            return None;
        }
        let root = discriminant.sqrt();
        let distance = dot(o_across, o_across).sqrt();
        let c = (distance - radius) * (distance + radius);
        let approaching = b.negative();
        let q = approaching.select(root - b, zero - b - root);
        let (first, second) = (q / a, c / q);
        let (near, far) = (approaching.select(second, first), approaching.select(first, second));
        let on_wall = |t: F64x4| {
            let z = along_o + along_d * t;
            start.below(t) & zero.at_most(z) & z.at_most(self.length)
        };
        let near = from.select(F64x4::splat(f64::NAN), near);
        let far = from.select(F64x4::splat(-2.0) * to_nearest, far);
        let is_near = on_wall(near);
        let met = met & (is_near | on_wall(far));
        Some(Crossing::plain(is_near.select(near, far), self.primitives, met))
    }
}
