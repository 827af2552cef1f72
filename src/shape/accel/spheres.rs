//! Four spheres at a time.

use super::{Rays, Search};
use crate::math::simd::{F64x4, dot};
use crate::shape::Sphere;

/// Four spheres; missing ones have a radius that no ray meets.
#[derive(Clone, Debug)]
pub struct Spheres {
    centre: [F64x4; 3],
    radius: F64x4,
    /// r²; negative in missing lanes.
    radius2: F64x4,
    primitives: [u32; 4],
}

impl Spheres {
    pub fn new(items: &[(&Sphere, u32)]) -> Self {
        let lanes = |f: &dyn Fn(&Sphere) -> f64, rest: f64| {
            F64x4::new(std::array::from_fn(|i| items.get(i).map_or(rest, |(s, _)| f(s))))
        };
        Self {
            centre: [0, 1, 2].map(|axis| lanes(&|s| s.centre[axis], 0.0)),
            radius: lanes(&|s| s.radius, 0.0),
            radius2: lanes(&|s| s.radius * s.radius, -1.0),
            primitives: std::array::from_fn(|i| {
                items.get(i).map_or(Search::NONE, |(_, primitive)| *primitive)
            }),
        }
    }

    /// The nearest crossing beyond the ray's start.
    ///
    /// With o relative to the centre and |d| = 1: t² + 2(o·d)t + (o² − r²) = 0. The discriminant is taken as
    /// r² − |o − (o·d)d|², which does not cancel for small distant spheres (Haines et al. 2019), and the root of
    /// smaller size as c/q. A ray that starts on a sphere has c = 0 exactly, so its other root is −2 o·d.
    #[inline(always)]
    pub fn intersect(&self, rays: &Rays, search: &mut Search) {
        let o = [0, 1, 2].map(|axis| rays.origin[axis] - self.centre[axis]);
        let b = dot(o, rays.direction);
        let nearest = [0, 1, 2].map(|axis| o[axis] - rays.direction[axis] * b);
        let discriminant = self.radius2 - dot(nearest, nearest);
        let from = (0..4).fold(0, |bits, i| bits | u32::from(self.primitives[i] == search.ray.from) << i);
        let from = if search.ray.from == Search::NONE { 0 } else { from };
        let mut candidates = F64x4::splat(0.0).at_most(discriminant) | from;
        if candidates == 0 {
            return;
        }
        let root = discriminant.sqrt();
        let distance = dot(o, o).sqrt();
        let c = (distance - self.radius) * (distance + self.radius);
        let q = b.negative_select(root - b, -b - root);
        let other = c / q;
        let near = b.negative_select(other, q).to_array();
        let far = b.negative_select(q, other).to_array();
        let b = b.to_array();
        while candidates != 0 {
            let i = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let t = if from >> i & 1 == 1 {
                -2.0 * b[i]
            } else if near[i] > search.ray.start {
                near[i]
            } else {
                far[i]
            };
            if t > search.ray.start {
                search.offer(t, 0.0, 0.0, self.primitives[i]);
            }
        }
    }
}
