//! Blocks of four primitives of a kind, side by side: what all kinds but triangles have in common. A file for
//! each kind says where lines cross it.

use super::Search;
use super::packet::Packet;
use crate::math::simd::{F64x4, Mask};
use crate::math::{DVec3, Ray};

/// A ray in each lane.
pub struct Rays {
    pub origin: [F64x4; 3],
    pub direction: [F64x4; 3],
    pub start: F64x4,
    /// End of each search: the ray's end, or the best hit that was known when this was made.
    pub end: F64x4,
    /// The [`lane`](Packet::lane) of the primitive that it leaves.
    pub from: F64x4,
}

impl Rays {
    /// The ray of a search in every lane.
    #[inline(always)]
    pub fn alike(&Search { ray, best }: &Search) -> Self {
        Self {
            origin: ray.origin.to_array().map(F64x4::splat),
            direction: ray.direction.to_array().map(F64x4::splat),
            start: F64x4::splat(ray.start),
            end: F64x4::splat(best.t),
            from: F64x4::splat(Packet::lane(ray.from)),
        }
    }

    #[inline(always)]
    pub fn of(rays: [&Ray; 4]) -> Self {
        let lanes = |f: &dyn Fn(&Ray) -> f64| F64x4::new(rays.map(f));
        Self {
            origin: [lanes(&|r| r.origin.x), lanes(&|r| r.origin.y), lanes(&|r| r.origin.z)],
            direction: [lanes(&|r| r.direction.x), lanes(&|r| r.direction.y), lanes(&|r| r.direction.z)],
            start: lanes(&|r| r.start),
            end: lanes(&|r| r.end),
            from: lanes(&|r| Packet::lane(r.from)),
        }
    }
}

/// Where the ray of each lane may meet the primitive of that lane.
pub struct Crossing {
    pub t: F64x4,
    /// First coordinate; see [`Hit`](crate::shape::Hit).
    pub u: F64x4,
    /// Second coordinate; see [`Hit`](crate::shape::Hit).
    pub v: F64x4,
    /// The [`lane`](Packet::lane) of the primitive that is crossed.
    pub primitive: F64x4,
    /// Lanes in which this is a hit, if it lies between the ray's start and end.
    pub met: Mask,
}

impl Crossing {
    /// A crossing of shapes that find their points without coordinates.
    #[inline(always)]
    pub fn plain(t: F64x4, primitive: F64x4, met: Mask) -> Self {
        let zero = F64x4::splat(0.0);
        Self { t, u: zero, v: zero, primitive, met }
    }
}

/// Up to four primitives of a kind.
pub trait Block: Sized {
    type Shape;

    /// From shapes, each with the number of its first primitive.
    fn new(items: &[(&Self::Shape, u32)]) -> Self;

    /// The [`lane`](Packet::lane) of each shape's first primitive; NaN for missing ones.
    fn primitives(&self) -> &F64x4;

    /// A block with the shape of one lane in every lane.
    fn spread(&self, lane: usize) -> Self;

    /// Where the ray of each lane crosses the shape of that lane; `None` if there is no hit before the end of
    /// any.
    fn cross(&self, rays: &Rays) -> Option<Crossing>;

    /// Tests one ray, which is in every lane of `rays`, against all shapes.
    #[inline(always)]
    fn intersect(&self, rays: &Rays, search: &mut Search) {
        let Some(Crossing { t, u, v, primitive, met }) = self.cross(rays) else { return };
        let ahead = rays.start.below(t) & t.at_most(F64x4::splat(search.best.t));
        let mut hits = (met & ahead).bits();
        while hits != 0 {
            let i = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            search.offer(t.lane(i), u.lane(i), v.lane(i), Packet::primitive(primitive.lane(i)));
        }
    }

    /// Tests four rays against one shape after another.
    #[inline(always)]
    fn intersect_packet(&self, packet: &mut Packet) {
        for (lane, _) in self.there() {
            if let Some(crossing) = self.spread(lane).cross(&packet.rays) {
                packet.offer(&crossing);
            }
        }
    }

    /// The lanes that are not missing, and the number of each one's first primitive.
    #[inline(always)]
    fn there(&self) -> impl Iterator<Item = (usize, u32)> {
        let primitives = self.primitives();
        let there = (0..4).map(|lane| (lane, primitives.lane(lane))).take_while(|(_, lane)| !lane.is_nan());
        there.map(|(lane, primitive)| (lane, Packet::primitive(primitive)))
    }
}

/// A number for each shape; `rest` for missing ones.
pub fn lanes<S>(items: &[(&S, u32)], rest: f64, f: impl Fn(&S) -> f64) -> F64x4 {
    F64x4::new(std::array::from_fn(|i| items.get(i).map_or(rest, |(shape, _)| f(shape))))
}

/// A vector for each shape; for missing ones all its components are `rest`.
pub fn vectors<S>(items: &[(&S, u32)], rest: f64, f: impl Fn(&S) -> DVec3) -> [F64x4; 3] {
    [0, 1, 2].map(|axis| lanes(items, rest, |shape| f(shape)[axis]))
}

/// The lanes of [`Block::primitives`].
pub fn numbers<S>(items: &[(&S, u32)]) -> F64x4 {
    F64x4::new(std::array::from_fn(|i| items.get(i).map_or(f64::NAN, |(_, first)| Packet::lane(*first))))
}

/// The vector of one lane, in all lanes.
#[inline(always)]
pub fn spread(vector: &[F64x4; 3], lane: usize) -> [F64x4; 3] {
    [0, 1, 2].map(|axis| vector[axis].spread(lane))
}

/// The vector of one lane.
pub fn vector(vector: &[F64x4; 3], lane: usize) -> DVec3 {
    DVec3::from_array(vector.each_ref().map(|axis| axis.lane(lane)))
}
