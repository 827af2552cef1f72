//! The radiance along one ray.

use super::{AnySensor, Optics, Sensor, one_pixel};
use crate::math::{DVec2, DVec3, Ray};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "radiancemeter";
pub const ABOUT: &str = "Measures the radiance along one ray; its film is one pixel.";
pub const EXAMPLES: &[&str] = &[r#"<sensor type="radiancemeter"><point name="origin" x="0" y="1" z="4"/>
    <vector name="direction" x="0" y="-0.2" z="-1"/></sensor>"#];

/// Looks along one ray.
#[derive(Clone, Debug)]
pub struct RadianceMeter {
    origin: DVec3,
    direction: DVec3,
}

pub fn parse(params: &mut Params) -> Result<Sensor, SceneError> {
    let recorded = one_pixel(params)?;
    let origin = params.vector("origin", None, "where it is; beside `direction`")?;
    let towards = params.vector("direction", None, "where it looks; beside `origin`")?;
    let to_world = params.transform("to_world", "instead of both: it looks along +z from the origin")?;
    let (origin, towards) = match (params.has("to_world"), origin, towards) {
        (true, ..) | (false, None, None) => (to_world.point(DVec3::ZERO), to_world.vector(DVec3::Z)),
        (false, Some(origin), Some(towards)) => (origin, towards),
        (false, Some(_), None) => {
            return Err(params.error("origin", "`origin` without `direction`", "expected both or neither"));
        }
        (false, None, Some(_)) => {
            return Err(params.error(
                "direction",
                "`direction` without `origin`",
                "expected both or neither",
            ));
        }
    };
    let direction = params.unit_direction(towards)?;
    Ok(recorded.with(AnySensor::RadianceMeter(RadianceMeter { origin, direction })))
}

impl Optics for RadianceMeter {
    /// Always the same.
    #[inline]
    fn ray(&self, _: DVec2, _: DVec2) -> Ray {
        Ray::free(self.origin, self.direction)
    }
}
