//! The pinhole camera.

use super::{AnySensor, Foreshortening, Optics, Sensor, View, common, half_width, require_rigid};
use crate::math::frame::{length, unit};
use crate::math::{DVec2, DVec3, Ray, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "perspective";
pub const ABOUT: &str = "A pinhole camera: everything is sharp.";
pub const EXAMPLES: &[&str] = &[r#"<sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, 1, -5" target="0, 1, 0" up="0, 1, 0"/></transform></sensor>"#];

/// A pinhole camera.
#[derive(Clone, Debug)]
pub struct Perspective {
    to_world: Transform,
    /// Half the size of the image at distance 1.
    half: DVec2,
    foreshortening: Foreshortening,
    principal_offset: DVec2,
    near: f64,
    far: f64,
}

pub fn parse(params: &mut Params) -> Result<Sensor, SceneError> {
    let common = common(params)?;
    params.optional_float("focus_distance", "of a `thinlens`; ignored here, as in Mitsuba")?;
    let half = half_width(params, common.aspect())?;
    let half = DVec2::new(half, half / common.aspect());
    let x = params.float("principal_point_offset_x", 0.0, "of the film's centre, in film widths")?;
    let y = params.float("principal_point_offset_y", 0.0, "of the film's centre, in film heights")?;
    require_rigid(params, &common.to_world, "a camera")?;
    let camera = AnySensor::Perspective(Perspective {
        to_world: common.to_world,
        half,
        foreshortening: Foreshortening::new(&common.to_world, half),
        principal_offset: DVec2::new(x, y),
        near: common.near,
        far: common.far,
    });
    Ok(common.with(camera))
}

impl Optics for Perspective {
    #[inline]
    fn ray(&self, film: DVec2, _: DVec2) -> Ray {
        let p = (DVec2::ONE - 2.0 * (film + self.principal_offset)) * self.half;
        let d = DVec3::new(p.x, p.y, 1.0);
        let per_depth = length(d);
        let direction = unit(self.to_world.vector(d));
        let origin = self.to_world.point(DVec3::ZERO) + direction * (self.near * per_depth);
        Ray { end: (self.far - self.near) * per_depth, ..Ray::free(origin, direction) }
    }

    fn has_image(&self) -> bool {
        true
    }

    #[inline]
    fn connect(&self, p: DVec3, _: DVec2) -> Option<View> {
        let local = self.to_world.inverse.transform_point3(p);
        if !(local.z > self.near && local.z < self.far) {
            return None;
        }
        let d = local / local.z;
        let towards = self.to_world.point(DVec3::ZERO) - p;
        let distance = length(towards);
        let towards = towards / distance;
        Some(View {
            towards,
            distance: distance - self.near * length(d),
            film: 0.5 * (DVec2::ONE - d.truncate() / self.half) - self.principal_offset,
            per_area: self.foreshortening.per_area(-towards, p),
        })
    }

    fn seen_per_area(&self, ray: &Ray, p: DVec3) -> f64 {
        self.foreshortening.per_area(ray.direction, p)
    }
}
