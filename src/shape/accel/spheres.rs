//! Spheres.

use super::block::{Block, Crossing, Rays, lanes, numbers, spread, vector, vectors};
use crate::math::Bounds;
use crate::math::simd::{F64x4, dot};
use crate::shape::Sphere;

/// Four spheres; missing ones have a radius that no ray meets.
#[derive(Clone, Debug)]
pub struct Spheres {
    centre: [F64x4; 3],
    radius: F64x4,
    /// r²; negative in missing lanes.
    radius2: F64x4,
    primitives: F64x4,
}

impl Spheres {
    /// The corners of a box around each.
    pub fn bounds(&self) -> impl Iterator<Item = Bounds> {
        self.there().map(|(lane, _)| {
            let (centre, radius) = (vector(&self.centre, lane), self.radius.lane(lane));
            (centre - radius, centre + radius)
        })
    }
}

impl Block for Spheres {
    type Shape = Sphere;

    fn new(items: &[(&Sphere, u32)]) -> Self {
        Self {
            centre: vectors(items, 0.0, |s| s.centre),
            radius: lanes(items, 0.0, |s| s.radius),
            radius2: lanes(items, -1.0, |s| s.radius * s.radius),
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
            radius: self.radius.spread(lane),
            radius2: self.radius2.spread(lane),
            primitives: self.primitives.spread(lane),
        }
    }

    /// The nearest crossing of a line and a sphere beyond `start`.
    ///
    /// With o relative to the centre and |d| = 1: t² + 2(o·d)t + (o² − r²) = 0. The discriminant is taken as
    /// r² − |o − (o·d)d|², which does not cancel for small distant spheres (Haines et al. 2019), and the root
    /// of smaller size as c/q. A ray that starts on the sphere has c = 0 exactly; its other root is −2 o·d.
    #[inline(always)]
    fn cross(&self, Rays { origin, direction, start, from, .. }: &Rays) -> Option<Crossing> {
        let from = from.equals(self.primitives);
        let o = [0, 1, 2].map(|axis| origin[axis] - self.centre[axis]);
        let b = dot(o, *direction);
        let nearest = [0, 1, 2].map(|axis| o[axis] - direction[axis] * b);
        let discriminant = self.radius2 - dot(nearest, nearest);
        let met = F64x4::splat(0.0).at_most(discriminant) | from;
        if met.bits() == 0 {
            return None;
        }
        let root = discriminant.sqrt();
        let distance = dot(o, o).sqrt();
        let c = (distance - self.radius) * (distance + self.radius);
        let approaching = b.negative();
        let q = approaching.select(root - b, -b - root);
        let other = c / q;
        let (near, far) = (approaching.select(other, q), approaching.select(q, other));
        let t = start.below(near).select(near, far);
        let t = from.select(F64x4::splat(-2.0) * b, t);
        Some(Crossing::plain(t, self.primitives, met))
    }
}
