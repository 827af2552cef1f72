//! Distance to what is seen.

use super::{AnyIntegrator, Counters};
use crate::math::Ray;
use crate::scene::Scene;
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "depth";
pub const ABOUT: &str =
    "The distance to the first surface, in all three channels as in Mitsuba; 0 where there is none.";
pub const EXAMPLES: &[&str] = &[r#"<integrator type="depth"/>"#];

/// The distance along the camera ray to the first surface.
#[derive(Clone, Copy, Debug)]
pub struct Depth;

pub fn parse(_: &mut Params) -> Result<AnyIntegrator, SceneError> {
    Ok(AnyIntegrator::Depth(Depth))
}

impl Depth {
    pub fn values(&self, scene: &Scene, ray: &Ray, counters: &mut Counters, values: &mut [f64]) {
        counters.rays += 1;
        values.fill(scene.accel.closest(ray).map_or(0.0, |hit| hit.t));
    }
}
