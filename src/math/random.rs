//! Numbers of a stream, and directions for tests.

#[cfg(test)]
use super::{DVec2, DVec3, warp};
use rand_pcg::{Pcg32, rand_core::Rng};

/// A number in [0, 1).
#[inline]
pub fn uniform(rng: &mut Pcg32) -> f64 {
    f64::from(rng.next_u32()) / 4294967296.0
}

/// A direction, uniform over the sphere.
#[cfg(test)]
pub fn direction(rng: &mut Pcg32) -> DVec3 {
    warp::sphere(DVec2::new(uniform(rng), uniform(rng)))
}
