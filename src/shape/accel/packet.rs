//! Four rays that are tested together against one primitive after another, where there are few.

use super::block::{Crossing, Rays};
use crate::math::Ray;
use crate::math::ray::NO_PRIMITIVE;
use crate::math::simd::F64x4;
use crate::shape::Hit;

/// Four rays and the best hit of each so far.
pub struct Packet {
    /// The rays, which end at their best hits.
    pub rays: Rays,
    u: F64x4,
    v: F64x4,
    /// The [`lane`](Packet::lane) of the best hit's primitive; [`NOTHING`] where there is none.
    primitive: F64x4,
}

/// Offset of primitive numbers in lanes: primitive n is the lane 2⁵² + 1 + n, with n + 1 in the low bits.
const NUMBERS: f64 = (1u64 << 52) as f64;

/// The lane of no primitive, before all others: a hit at the very end of a ray does not win the tie against
/// it.
const NOTHING: f64 = NUMBERS;

impl Packet {
    pub const WIDTH: usize = 4;

    #[inline(always)]
    pub fn new(rays: [&Ray; Self::WIDTH]) -> Self {
        let zero = F64x4::splat(0.0);
        Self { rays: Rays::of(rays), u: zero, v: zero, primitive: F64x4::splat(NOTHING) }
    }

    /// A primitive's number as a float that can be compared in registers.
    #[inline(always)]
    pub fn lane(primitive: u32) -> f64 {
        NUMBERS + 1.0 + f64::from(primitive)
    }

    /// The primitive of a lane; [`NO_PRIMITIVE`] for that of nothing.
    #[inline(always)]
    pub fn primitive(lane: f64) -> u32 {
        const { assert!(NO_PRIMITIVE == 0u32.wrapping_sub(1)) };
        (lane.to_bits() as u32).wrapping_sub(1)
    }

    /// Takes the hits that come before the best: by distance, then by primitive.
    #[inline(always)]
    pub fn offer(&mut self, &Crossing { t, u, v, primitive, met }: &Crossing) {
        let tie = t.equals(self.rays.end) & primitive.below(self.primitive);
        let better = met & self.rays.start.below(t) & (t.below(self.rays.end) | tie);
        self.rays.end = better.select(t, self.rays.end);
        self.u = better.select(u, self.u);
        self.v = better.select(v, self.v);
        self.primitive = better.select(primitive, self.primitive);
    }

    /// Whether every ray met something.
    #[inline(always)]
    pub fn all_found(&self) -> bool {
        F64x4::splat(NOTHING).below(self.primitive).bits() == 0b1111
    }

    /// The best hit of a ray; where there is none it lies at the ray's end.
    #[inline(always)]
    pub fn hit(&self, ray: usize) -> Hit {
        let primitive = Self::primitive(self.primitive.lane(ray));
        Hit { t: self.rays.end.lane(ray), u: self.u.lane(ray), v: self.v.lane(ray), primitive }
    }
}
