//! Which side of a surface a direction is on, for models that scatter through it. Directions are in the local frame.

use crate::math::DVec3;

/// η far / η near for light that leaves to `wo`, from η inside / η outside.
#[inline]
pub fn relative_eta(eta: f64, wo: DVec3) -> f64 {
    if wo.z > 0.0 { eta } else { 1.0 / eta }
}

/// `w` turned about the surface if the viewer is below it.
#[inline]
pub fn upward(w: DVec3, viewer: DVec3) -> DVec3 {
    if viewer.z < 0.0 { -w } else { w }
}
