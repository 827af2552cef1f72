//! The camera of parallel rays.

use super::{AnySensor, Sensor, common};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, Ray, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "orthographic";
pub const ABOUT: &str = "Parallel rays; the image is two units wide unless `to_world` scales it.";
pub const EXAMPLES: &[&str] = &[
    r#"<sensor type="orthographic"><transform name="to_world"><scale x="10" y="10"/></transform></sensor>"#,
];

#[derive(Clone, Debug)]
pub struct Orthographic {
    to_world: Transform,
    aspect: f64,
    near: f64,
    far: f64,
}

pub fn parse(params: &mut Params) -> Result<Sensor, SceneError> {
    let common = common(params)?;
    params.optional_float("focus_distance", "of a `thinlens`; ignored here, as in Mitsuba")?;
    let camera = AnySensor::Orthographic(Orthographic {
        to_world: common.to_world,
        aspect: common.film.aspect(),
        near: common.near,
        far: common.far,
    });
    Ok(Sensor { camera, film: common.film, sampler: common.sampler })
}

impl Orthographic {
    #[inline]
    pub fn ray(&self, film: DVec2) -> Ray {
        let p = DVec3::new(1.0 - 2.0 * film.x, (1.0 - 2.0 * film.y) / self.aspect, self.near);
        let direction = unit(self.to_world.vector(DVec3::Z));
        Ray { end: self.far - self.near, ..Ray::free(self.to_world.point(p), direction) }
    }
}
