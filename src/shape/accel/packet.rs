//! Four rays that are tried together against one primitive after another, where there are few.

use super::Search;
use crate::math::Ray;
use crate::math::simd::{F64x4, Mask};
use crate::shape::Hit;

/// Four rays and the best hit of each so far.
pub struct Packet {
    pub origin: [F64x4; 3],
    pub direction: [F64x4; 3],
    pub start: F64x4,
    pub from: F64x4,
    t: F64x4,
    u: F64x4,
    v: F64x4,
    /// The [`lane`](Packet::lane) of the best hit's primitive; [`NOTHING`] where there is none.
    primitive: F64x4,
}

/// Primitive n is lane 2⁵² + 1 + n: one more than its number is in the low bits.
const NUMBERS: f64 = (1u64 << 52) as f64;

/// Comes before every primitive: a hit at the very end of a ray does not win the tie against it.
const NOTHING: f64 = NUMBERS;

impl Packet {
    pub const WIDTH: usize = 4;

    #[inline(always)]
    pub fn new(rays: [&Ray; Self::WIDTH]) -> Self {
        let lanes = |f: &dyn Fn(&Ray) -> f64| F64x4::new(rays.map(f));
        let zero = F64x4::splat(0.0);
        Self {
            origin: [lanes(&|r| r.origin.x), lanes(&|r| r.origin.y), lanes(&|r| r.origin.z)],
            direction: [lanes(&|r| r.direction.x), lanes(&|r| r.direction.y), lanes(&|r| r.direction.z)],
            start: lanes(&|r| r.start),
            from: lanes(&|r| Self::lane(r.from)),
            t: lanes(&|r| r.end),
            u: zero,
            v: zero,
            primitive: F64x4::splat(NOTHING),
        }
    }

    /// A primitive's number as something to be compared.
    #[inline(always)]
    pub fn lane(primitive: u32) -> f64 {
        NUMBERS + 1.0 + f64::from(primitive)
    }

    /// The primitive of a lane, and none of that of nothing.
    #[inline(always)]
    pub fn primitive(lane: f64) -> u32 {
        const { assert!(Search::NONE == 0u32.wrapping_sub(1)) };
        (lane.to_bits() as u32).wrapping_sub(1)
    }

    /// Which rays would look as far as `t`.
    #[inline(always)]
    pub fn ahead(&self, t: F64x4) -> Mask {
        self.start.below(t) & t.at_most(self.t)
    }

    /// Takes the hits that come before the best: by distance, then by primitive.
    #[inline(always)]
    pub fn offer(&mut self, t: F64x4, u: F64x4, v: F64x4, primitive: F64x4, valid: Mask) {
        let tie = t.equals(self.t) & primitive.below(self.primitive);
        let better = valid & self.start.below(t) & (t.below(self.t) | tie);
        self.t = better.select(t, self.t);
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
        Hit { t: self.t.lane(ray), u: self.u.lane(ray), v: self.v.lane(ray), primitive }
    }
}
