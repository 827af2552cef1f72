//! Flat patches: four at a time against a ray, or one at a time against four rays.

use super::packet::Packet;
use super::shaft::Plane;
use super::{Rays, Search};
use crate::math::DVec3;
use crate::math::simd::{F64x4, Mask, dot};
use crate::shape::patch::{Outline, Patch};

/// Four patches; missing ones have no normal and are never met.
#[derive(Clone, Debug)]
pub struct Patches {
    centre: [F64x4; 3],
    /// Unit normal along e₁ × e₂.
    normal: [F64x4; 3],
    /// Products with p − centre are the patch coordinates x and y.
    dual: [[F64x4; 3]; 2],
    /// 1 where x² + y² must not exceed 1, 0 where it may: by how much the disk test counts.
    round: F64x4,
    primitives: [u32; 4],
}

/// Where lines meet planes: the distance along the line, the patch coordinates, and whether they are within.
struct Crossing {
    t: F64x4,
    x: F64x4,
    y: F64x4,
    within: Mask,
}

/// A line and a plane in each lane.
#[inline(always)]
fn cross(
    (centre, normal, dual, round): ([F64x4; 3], [F64x4; 3], [[F64x4; 3]; 2], F64x4),
    origin: &[F64x4; 3],
    direction: &[F64x4; 3],
) -> Crossing {
    let relative = [0, 1, 2].map(|axis| centre[axis] - origin[axis]);
    let t = dot(normal, relative) / dot(normal, *direction);
    let p = [0, 1, 2].map(|axis| t * direction[axis] - relative[axis]);
    let (x, y) = (dot(dual[0], p), dot(dual[1], p));
    let one = F64x4::splat(1.0);
    // A circle lies within the square of the same coordinates.
    let in_square = x.abs().max(y.abs()).at_most(one);
    let in_circle = (round * (x * x + y * y)).at_most(one);
    Crossing { t, x, y, within: in_square & in_circle }
}

impl Patches {
    pub fn new(items: &[(&Patch, u32)]) -> Self {
        let lanes = |f: &dyn Fn(&Patch) -> DVec3| {
            [0, 1, 2].map(|axis| {
                F64x4::new(std::array::from_fn(|i| items.get(i).map_or(0.0, |(p, _)| f(p)[axis])))
            })
        };
        let round = |(patch, _): &(&Patch, u32)| f64::from(u8::from(patch.outline == Outline::Circle));
        Self {
            centre: lanes(&|p| p.centre),
            normal: lanes(&|p| crate::math::frame::unit(p.e1.cross(p.e2))),
            dual: [lanes(&|p| p.dual().0), lanes(&|p| p.dual().1)],
            round: F64x4::new(std::array::from_fn(|i| items.get(i).map_or(0.0, round))),
            primitives: std::array::from_fn(|i| {
                items.get(i).map_or(Search::NONE, |(_, primitive)| *primitive)
            }),
        }
    }

    /// Each patch's number, its plane, and the corners of a box around it.
    pub fn outlines(&self) -> impl Iterator<Item = (u32, Plane, (DVec3, DVec3))> {
        let vector =
            |lanes: &[F64x4; 3], lane: usize| DVec3::from_array(lanes.map(|axis| axis.to_array()[lane]));
        let there = (0..4).filter(|&lane| self.primitives[lane] != Search::NONE);
        there.map(move |lane| {
            let [centre, n] = [&self.centre, &self.normal].map(|vectors| vector(vectors, lane));
            let [d1, d2] = self.dual.each_ref().map(|vectors| vector(vectors, lane));
            // What is normal to one dual vector is along the edge of the other.
            let edge = |d: DVec3, other: DVec3| other.cross(n) / d.dot(other.cross(n));
            let reach = edge(d1, d2).abs() + edge(d2, d1).abs();
            (self.primitives[lane], Plane::new(centre, n), (centre - reach, centre + reach))
        })
    }

    #[inline(always)]
    pub fn intersect(&self, rays: &Rays, search: &mut Search) {
        let planes = (self.centre, self.normal, self.dual, self.round);
        let Crossing { t, x, y, within } = cross(planes, &rays.origin, &rays.direction);
        let ahead = rays.start.below(t) & t.at_most(F64x4::splat(search.best.t));
        let mut hits = (within & ahead).bits();
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

    /// The same for four rays.
    #[inline(always)]
    pub fn intersect_packet(&self, packet: &mut Packet) {
        for lane in 0..4 {
            if self.primitives[lane] == Search::NONE {
                break;
            }
            let spread = |vector: &[F64x4; 3]| [0, 1, 2].map(|axis| vector[axis].spread(lane));
            let dual = [spread(&self.dual[0]), spread(&self.dual[1])];
            let plane = (spread(&self.centre), spread(&self.normal), dual, self.round.spread(lane));
            let Crossing { t, x, y, within } = cross(plane, &packet.origin, &packet.direction);
            if packet.ahead(t).bits() == 0 {
                continue;
            }
            let primitive = F64x4::splat(Packet::lane(self.primitives[lane]));
            let elsewhere = within.without(packet.from.equals(primitive));
            packet.offer(t, x, y, primitive, elsewhere);
        }
    }
}
