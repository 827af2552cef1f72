//! Spheres: four at a time against a ray, or one at a time against four rays.

use super::packet::Packet;
use super::{Rays, Search};
use crate::math::DVec3;
use crate::math::simd::{F64x4, Mask, dot};
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

/// The nearest crossing of a line and a sphere beyond `start`, in each lane, and whether there is one.
///
/// With o relative to the centre and |d| = 1: t² + 2(o·d)t + (o² − r²) = 0. The discriminant is taken as
/// r² − |o − (o·d)d|², which does not cancel for small distant spheres (Haines et al. 2019), and the root of
/// smaller size as c/q. A ray that starts on the sphere (`from`) has c = 0 exactly, so its other root is
/// −2 o·d.
#[inline(always)]
fn cross(
    (centre, radius, radius2): ([F64x4; 3], F64x4, F64x4),
    origin: &[F64x4; 3],
    direction: &[F64x4; 3],
    start: F64x4,
    from: Mask,
) -> Option<(F64x4, Mask)> {
    let o = [0, 1, 2].map(|axis| origin[axis] - centre[axis]);
    let b = dot(o, *direction);
    let nearest = [0, 1, 2].map(|axis| o[axis] - direction[axis] * b);
    let discriminant = radius2 - dot(nearest, nearest);
    let met = F64x4::splat(0.0).at_most(discriminant) | from;
    if met.bits() == 0 {
        return None;
    }
    let root = discriminant.sqrt();
    let distance = dot(o, o).sqrt();
    let c = (distance - radius) * (distance + radius);
    let receding = b.negative();
    let q = receding.select(root - b, -b - root);
    let other = c / q;
    let (near, far) = (receding.select(other, q), receding.select(q, other));
    let t = start.below(near).select(near, far);
    let t = from.select(F64x4::splat(-2.0) * b, t);
    Some((t, met & start.below(t)))
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

    /// The corners of a box around each.
    pub fn bounds(&self) -> impl Iterator<Item = (DVec3, DVec3)> {
        let radius = self.radius.to_array();
        let centre = self.centre.map(|axis| axis.to_array());
        let there = (0..4).filter(|&lane| self.primitives[lane] != Search::NONE);
        there.map(move |lane| {
            let centre = DVec3::from_array(centre.map(|axis| axis[lane]));
            (centre - radius[lane], centre + radius[lane])
        })
    }

    #[inline(always)]
    pub fn intersect(&self, rays: &Rays, search: &mut Search) {
        let is_from = self.primitives.map(|p| f64::from(u8::from(p == search.ray.from && p != Search::NONE)));
        let from = F64x4::splat(0.0).below(F64x4::new(is_from));
        let spheres = (self.centre, self.radius, self.radius2);
        let Some((t, met)) = cross(spheres, &rays.origin, &rays.direction, rays.start, from) else { return };
        let (mut hits, t) = (met.bits(), t.to_array());
        while hits != 0 {
            let i = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            search.offer(t[i], 0.0, 0.0, self.primitives[i]);
        }
    }

    /// The same for four rays.
    #[inline(always)]
    pub fn intersect_packet(&self, packet: &mut Packet) {
        for lane in 0..4 {
            if self.primitives[lane] == Search::NONE {
                break;
            }
            let centre = [0, 1, 2].map(|axis| self.centre[axis].spread(lane));
            let sphere = (centre, self.radius.spread(lane), self.radius2.spread(lane));
            let primitive = F64x4::splat(Packet::lane(self.primitives[lane]));
            let from = packet.from.equals(primitive);
            let crossing = cross(sphere, &packet.origin, &packet.direction, packet.start, from);
            let Some((t, met)) = crossing else { continue };
            let zero = F64x4::splat(0.0);
            packet.offer(t, zero, zero, primitive, met);
        }
    }
}
