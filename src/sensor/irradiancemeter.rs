//! The irradiance of a surface.

use super::{AnySensor, Optics, Sensor, one_pixel};
use crate::math::{DVec2, DVec3, Frame, Ray, Transform, warp};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::{AreaSample, Geometry, Outline, Patch};
use std::sync::Arc;

pub const NAME: &str = "irradiancemeter";
pub const ABOUT: &str =
    "Within a shape: measures the mean irradiance of its surface, in W·m⁻²·nm⁻¹; its film is one pixel.";
pub const EXAMPLES: &[&str] = &[r#"<sensor type="irradiancemeter"/>"#];

/// Where a ray begins, and where it goes.
struct Start {
    p: DVec3,
    /// Rounding error of `p`.
    error: f64,
    primitive: u32,
    direction: DVec3,
}

/// Looks from points of a surface, even in area, to all sides of its front, in proportion to the cosine.
#[derive(Clone, Debug)]
pub struct IrradianceMeter {
    /// A square of its own until [`IrradianceMeter::lay_on`] says which.
    surface: Arc<Geometry>,
    first_primitive: u32,
}

pub fn parse(params: &mut Params) -> Result<Sensor, SceneError> {
    let square = Patch::new(&Transform::IDENTITY, false, Outline::Square);
    let meter = IrradianceMeter { surface: Arc::new(Geometry::Patch(square)), first_primitive: Ray::FREE };
    Ok(one_pixel(params)?.with(AnySensor::IrradianceMeter(meter)))
}

impl Optics for IrradianceMeter {
    /// From where by the place on the film, to where by that on the lens.
    #[inline]
    fn ray(&self, film: DVec2, lens: DVec2) -> Ray {
        let Start { p, error, primitive, direction } = self.start(film, lens);
        Ray { start: error, ..Ray::leaving(p, direction, f64::INFINITY, primitive) }
    }

    fn has_lens(&self) -> bool {
        true
    }

    fn lies_on_surface(&self) -> bool {
        true
    }
}

impl IrradianceMeter {
    /// Tells the surface, and the number of the first of its primitives.
    pub fn lay_on(&mut self, surface: Arc<Geometry>, first_primitive: u32) {
        (self.surface, self.first_primitive) = (surface, first_primitive);
    }

    // Not inlined, and not where the ray is: cameras would pay for either.
    #[inline(never)]
    fn start(&self, film: DVec2, lens: DVec2) -> Start {
        let AreaSample { p, n, primitive, error, .. } = self.surface.sample_area::<false>(film);
        let direction = Frame::about(n).to_world(warp::cosine_hemisphere(lens));
        Start { p, error, primitive: self.first_primitive.saturating_add(primitive), direction }
    }
}
