//! A camera with a lens.

use super::{AnySensor, Foreshortening, Optics, Sensor, View, common, half_width, require_rigid};
use crate::math::frame::{length, unit};
use crate::math::{DVec2, DVec3, Ray, Transform, warp};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "thinlens";
pub const ABOUT: &str = "A thin lens: only the plane of focus is sharp.";
pub const EXAMPLES: &[&str] = &[r#"<sensor type="thinlens"><float name="aperture_radius" value="0.1"/>
    <float name="focus_distance" value="5"/><float name="fov" value="40"/></sensor>"#];

/// Rays leave a point of the lens (a disk of radius b) towards the point of the plane of focus (at depth d)
/// that a pinhole at the lens's centre would see.
#[derive(Clone, Debug)]
pub struct ThinLens {
    to_world: Transform,
    half: DVec2,
    foreshortening: Foreshortening,
    aperture_radius: f64,
    focus_distance: f64,
    near: f64,
    far: f64,
}

pub fn parse(params: &mut Params) -> Result<Sensor, SceneError> {
    let common = common(params)?;
    let half = half_width(params, common.aspect())?;
    let expected = "a radius of at least 0";
    let aperture_radius =
        params.optional_float_where("aperture_radius", "radius of the lens", expected, |v| v >= 0.0)?;
    let Some(aperture_radius) = aperture_radius else {
        return Err(params.error(
            "aperture_radius",
            "a thinlens needs an `aperture_radius`",
            "add it, in scene units",
        ));
    };
    let expected = "a positive distance";
    let about = "depth of the plane of focus; `far_clip` by default";
    let focus_distance = params.float_where("focus_distance", common.far, about, expected, |v| v > 0.0)?;
    require_rigid(params, &common.to_world, "a camera")?;
    let half = DVec2::new(half, half / common.aspect());
    let camera = AnySensor::ThinLens(ThinLens {
        to_world: common.to_world,
        half,
        foreshortening: Foreshortening::new(&common.to_world, half),
        aperture_radius,
        focus_distance,
        near: common.near,
        far: common.far,
    });
    Ok(common.with(camera))
}

impl Optics for ThinLens {
    #[inline]
    fn ray(&self, film: DVec2, lens: DVec2) -> Ray {
        let p = (DVec2::ONE - 2.0 * film) * self.half;
        let on_lens = (warp::disk_concentric(lens) * self.aperture_radius).extend(0.0);
        // Divided by the focal distance, so that a focus at infinity gives parallel rays and no overflow.
        let d = DVec3::new(p.x, p.y, 1.0) - on_lens / self.focus_distance;
        let per_depth = length(d);
        let direction = unit(self.to_world.vector(d));
        let origin = self.to_world.point(on_lens) + direction * (self.near * per_depth);
        Ray { end: (self.far - self.near) * per_depth, ..Ray::free(origin, direction) }
    }

    fn has_lens(&self) -> bool {
        true
    }

    fn has_image(&self) -> bool {
        true
    }

    fn connect(&self, p: DVec3, lens: DVec2) -> Option<View> {
        let local = self.to_world.inverse.transform_point3(p);
        if !(local.z > self.near && local.z < self.far) {
            return None;
        }
        let on_lens = (warp::disk_concentric(lens) * self.aperture_radius).extend(0.0);
        let d = (local - on_lens) / local.z;
        let towards = self.to_world.point(on_lens) - p;
        let distance = length(towards);
        let towards = towards / distance;
        let place = d.truncate() + on_lens.truncate() / self.focus_distance;
        Some(View {
            towards,
            distance: distance - self.near * length(d),
            film: 0.5 * (DVec2::ONE - place / self.half),
            per_area: self.foreshortening.per_area(-towards, p),
        })
    }

    fn seen_per_area(&self, ray: &Ray, p: DVec3) -> f64 {
        self.foreshortening.per_area(ray.direction, p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_rays_of_a_pixel_meet_in_the_plane_of_focus() {
        let camera = ThinLens {
            to_world: Transform::IDENTITY,
            half: DVec2::new(0.5, 0.4),
            foreshortening: Foreshortening::new(&Transform::IDENTITY, DVec2::new(0.5, 0.4)),
            aperture_radius: 0.3,
            focus_distance: 7.0,
            near: 1e-2,
            far: 1e4,
        };
        let film = DVec2::new(0.2, 0.9);
        let expected = DVec3::new(0.6 * 0.5 * 7.0, -0.8 * 0.4 * 7.0, 7.0);
        for i in 0..100 {
            let ray = camera.ray(film, DVec2::new(i as f64 / 100.0, (i * 37 % 100) as f64 / 100.0));
            let p = ray.at((7.0 - ray.origin.z) / ray.direction.z);
            assert!(length(p - expected) < 1e-12, "{p}");
        }
    }
}
