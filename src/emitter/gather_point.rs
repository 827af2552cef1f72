//! A place where light is gathered, as far as the choice between emitters asks.

use crate::bsdf::Lobe;
use crate::math::DVec3;

/// A point where light is gathered.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint<'a> {
    /// The point (world).
    pub p: DVec3,
    pub gathers: &'a Gathers,
}

/// The directions from which light is scattered to the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathers {
    /// The normal (world, unit) of the hemisphere from which it is, by the cosine or nearly; zero if from all
    /// directions.
    pub n: DVec3,
    /// Those from which it is scattered most (world).
    pub lobe: Lobe,
}

impl Gathers {
    /// From all directions alike.
    pub const EVERYWHERE: Self = Self::about(DVec3::ZERO);

    /// From a hemisphere, by the cosine.
    pub const fn about(n: DVec3) -> Self {
        Self { n, lobe: Lobe::NONE }
    }

    /// At a point (world).
    #[inline(always)]
    pub fn at(&self, p: DVec3) -> GatherPoint<'_> {
        GatherPoint { p, gathers: self }
    }
}
