//! Four flat patches at a time.

use super::{Rays, Search};
use crate::math::DVec3;
use crate::math::simd::{F64x4, dot};
use crate::shape::patch::{Outline, Patch};

/// Four patches; missing ones have no normal and are never met.
#[derive(Clone, Debug)]
pub struct Patches {
    centre: [F64x4; 3],
    /// Unit normal along e₁ × e₂.
    normal: [F64x4; 3],
    /// Products with p − centre are the patch coordinates x and y.
    dual: [[F64x4; 3]; 2],
    /// Bits of the lanes that are parallelograms.
    square: u32,
    primitives: [u32; 4],
}

impl Patches {
    pub fn new(items: &[(&Patch, u32)]) -> Self {
        let lanes = |f: &dyn Fn(&Patch) -> DVec3| {
            [0, 1, 2].map(|axis| {
                F64x4::new(std::array::from_fn(|i| items.get(i).map_or(0.0, |(p, _)| f(p)[axis])))
            })
        };
        Self {
            centre: lanes(&|p| p.centre),
            normal: lanes(&|p| crate::math::frame::unit(p.e1.cross(p.e2))),
            dual: [lanes(&|p| p.dual().0), lanes(&|p| p.dual().1)],
            square: items
                .iter()
                .enumerate()
                .map(|(i, (p, _))| u32::from(p.outline == Outline::Square) << i)
                .sum(),
            primitives: std::array::from_fn(|i| {
                items.get(i).map_or(Search::NONE, |(_, primitive)| *primitive)
            }),
        }
    }

    #[inline(always)]
    pub fn intersect(&self, rays: &Rays, search: &mut Search) {
        let relative = [0, 1, 2].map(|axis| self.centre[axis] - rays.origin[axis]);
        let t = dot(self.normal, relative) / dot(self.normal, rays.direction);
        let p = [0, 1, 2].map(|axis| t * rays.direction[axis] - relative[axis]);
        let (x, y) = (dot(self.dual[0], p), dot(self.dual[1], p));
        let one = F64x4::splat(1.0);
        // A circle lies within the square of the same coordinates, so both tests may always be made.
        let in_square = x.abs().max(y.abs()).at_most(one);
        let in_circle = (x * x + y * y).at_most(one);
        let ahead = rays.start.below(t) & t.at_most(F64x4::splat(search.best.t));
        let mut hits = in_square & (in_circle | self.square) & ahead;
        if hits == 0 {
            return;
        }
        let (t, x, y) = (t.to_array(), x.to_array(), y.to_array());
        while hits != 0 {
            let i = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            if self.primitives[i] != search.ray.from {
                search.offer(t[i], x[i], y[i], self.primitives[i]);
            }
        }
    }
}
