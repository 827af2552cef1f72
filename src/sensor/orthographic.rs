//! The camera of parallel rays.

use super::{AnySensor, Optics, Sensor, View, common};
use crate::math::frame::{length, unit};
use crate::math::{DVec2, DVec3, Ray, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "orthographic";
pub const ABOUT: &str = "Parallel rays; the image is two units wide unless `to_world` scales it.";
pub const EXAMPLES: &[&str] = &[
    r#"<sensor type="orthographic"><transform name="to_world"><scale x="10" y="10"/></transform></sensor>"#,
];

/// A camera whose rays are parallel.
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
        aspect: common.aspect(),
        near: common.near,
        far: common.far,
    });
    Ok(common.with(camera))
}

impl Optics for Orthographic {
    #[inline]
    fn ray(&self, film: DVec2, _: DVec2) -> Ray {
        let p = DVec3::new(1.0 - 2.0 * film.x, (1.0 - 2.0 * film.y) / self.aspect, self.near);
        let direction = unit(self.to_world.vector(DVec3::Z));
        Ray { end: self.far - self.near, ..Ray::free(self.to_world.point(p), direction) }
    }

    fn has_image(&self) -> bool {
        true
    }

    fn connect(&self, p: DVec3, _: DVec2) -> Option<View> {
        let local = self.to_world.inverse.transform_point3(p);
        let forward = self.to_world.vector(DVec3::Z);
        let distance = (local.z - self.near) * length(forward);
        (distance > 0.0 && distance < self.far - self.near).then(|| View {
            towards: -unit(forward),
            distance,
            film: 0.5 * DVec2::new(1.0 - local.x, 1.0 - local.y * self.aspect),
            per_area: self.per_area(),
        })
    }

    fn seen_per_area(&self, _: &Ray, _: DVec3) -> f64 {
        self.per_area()
    }
}

impl Orthographic {
    /// The film is 2 × 2/aspect in local units; of the volume |det A| above them, |A z| is height.
    fn per_area(&self) -> f64 {
        let forward = length(self.to_world.vector(DVec3::Z));
        self.aspect * forward / (4.0 * self.to_world.matrix.determinant().abs())
    }
}
