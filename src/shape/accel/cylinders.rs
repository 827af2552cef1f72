//! Open cylinders: four at a time against a ray, or one at a time against four rays.

use super::packet::Packet;
use super::{Rays, Search};
use crate::math::simd::{F64x4, Mask, dot};
use crate::math::{Bounds, DVec3};
use crate::shape::Cylinder;
use crate::shape::cylinder::bounds;

/// Four cylinders; missing ones have a length that no point lies along.
#[derive(Clone, Debug)]
pub struct Cylinders {
    start: [F64x4; 3],
    /// Unit vector.
    axis: [F64x4; 3],
    length: F64x4,
    radius: F64x4,
    primitives: [u32; 4],
}

/// The nearest crossing of a line and a cylinder beyond `start`, in each lane, and whether there is one.
///
/// The sphere's equation in the plane across the axis, in which the direction has the length √a; of a line
/// along the axis a is 0 and nothing compares. A ray that starts on the cylinder (`from`) has its first root
/// at 0 exactly, so the other is −2b/a.
#[inline(always)]
fn cross(
    (origin, axis, length, radius): (&[F64x4; 3], &[F64x4; 3], F64x4, F64x4),
    ray: (&[F64x4; 3], &[F64x4; 3]),
    start: F64x4,
    from: Mask,
) -> Option<(F64x4, Mask)> {
    let zero = F64x4::splat(0.0);
    let o = [0, 1, 2].map(|i| ray.0[i] - origin[i]);
    let (along_o, along_d) = (dot(o, *axis), dot(*ray.1, *axis));
    let o_across = [0, 1, 2].map(|i| o[i] - axis[i] * along_o);
    let d_across = [0, 1, 2].map(|i| ray.1[i] - axis[i] * along_d);
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
    let receding = b.negative();
    let q = receding.select(root - b, zero - b - root);
    let (first, second) = (q / a, c / q);
    let (near, far) = (receding.select(second, first), receding.select(first, second));
    let on_wall = |t: F64x4| {
        let z = along_o + along_d * t;
        start.below(t) & zero.at_most(z) & z.at_most(length)
    };
    let near = from.select(F64x4::splat(f64::NAN), near);
    let far = from.select(F64x4::splat(-2.0) * to_nearest, far);
    let is_near = on_wall(near);
    Some((is_near.select(near, far), met & (is_near | on_wall(far))))
}

impl Cylinders {
    pub fn new(items: &[(&Cylinder, u32)]) -> Self {
        let lanes = |f: &dyn Fn(&Cylinder) -> f64, rest: f64| {
            F64x4::new(std::array::from_fn(|i| items.get(i).map_or(rest, |(c, _)| f(c))))
        };
        let vectors = |f: &dyn Fn(&Cylinder) -> DVec3| [0, 1, 2].map(|axis| lanes(&|c| f(c)[axis], 0.0));
        Self {
            start: vectors(&|c| c.start),
            axis: vectors(&|c| c.axis),
            length: lanes(&|c| c.length, f64::NAN),
            radius: lanes(&|c| c.radius, 0.0),
            primitives: std::array::from_fn(|i| {
                items.get(i).map_or(Search::NONE, |(_, primitive)| *primitive)
            }),
        }
    }

    /// The corners of a box around each.
    pub fn bounds(&self) -> impl Iterator<Item = Bounds> {
        let there = (0..4).filter(|&lane| self.primitives[lane] != Search::NONE);
        there.map(|lane| {
            let vector = |lanes: &[F64x4; 3]| DVec3::from_array(lanes.each_ref().map(|axis| axis.lane(lane)));
            let (start, axis) = (vector(&self.start), vector(&self.axis));
            bounds(start, axis, self.length.lane(lane), self.radius.lane(lane))
        })
    }

    #[inline(always)]
    pub fn intersect(&self, rays: &Rays, search: &mut Search) {
        let is_from = self.primitives.map(|p| f64::from(u8::from(p == search.ray.from && p != Search::NONE)));
        let from = F64x4::splat(0.0).below(F64x4::new(is_from));
        let cylinders = (&self.start, &self.axis, self.length, self.radius);
        let crossing = cross(cylinders, (&rays.origin, &rays.direction), rays.start, from);
        let Some((t, met)) = crossing else { return };
        let mut hits = met.bits();
        while hits != 0 {
            let i = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            search.offer(t.lane(i), 0.0, 0.0, self.primitives[i]);
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
            let (start, axis) = (spread(&self.start), spread(&self.axis));
            let cylinder = (&start, &axis, self.length.spread(lane), self.radius.spread(lane));
            let primitive = F64x4::splat(Packet::lane(self.primitives[lane]));
            let from = packet.from.equals(primitive);
            let crossing = cross(cylinder, (&packet.origin, &packet.direction), packet.start, from);
            let Some((t, met)) = crossing else { continue };
            let zero = F64x4::splat(0.0);
            packet.offer(t, zero, zero, primitive, met);
        }
    }
}
