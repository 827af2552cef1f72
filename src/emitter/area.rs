//! Surfaces that emit light.

use super::{AnyEmitter, DirectSample, Radiance};
use crate::math::cone::Cone;
use crate::math::ray::{free_way, position_error};
use crate::math::warp::cone_pdf;
use crate::math::{DVec2, DVec3, Ray};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::{AreaSample, Geometry, SphereSample, SurfacePoint};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;

pub const NAME: &str = "area";
pub const ABOUT: &str = "A shape whose front side shines equally into all directions.";
pub const EXAMPLES: &[&str] = &[
    r#"<emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter>"#,
    r#"<emitter type="area"><spectrum name="radiance" value="2"/></emitter>"#,
];

/// The radiance of a shape's front side.
#[derive(Debug)]
pub struct Area {
    radiance: AnyTexture,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let about = "radiance in W·m⁻²·sr⁻¹·nm⁻¹";
    Ok(AnyEmitter::Area(Area { radiance: params.texture("radiance", 1.0, Usage::Emission, about)? }))
}

impl Area {
    /// The radiance in W·m⁻²·sr⁻¹·nm⁻¹ that leaves a point of the surface in direction `w` (unit, world); none
    /// leaves its back.
    #[inline]
    pub fn radiance(&self, point: &SurfacePoint, w: DVec3, λ: &Wavelengths) -> Spectrum {
        if point.ng.dot(w) > 0.0 { self.radiance.eval(point.uv, λ) } else { Spectrum::ZERO }
    }

    /// Spheres are sampled within the cone they fill, all else uniformly in area.
    #[inline(always)]
    pub fn sample(&self, shape: &Geometry, p: DVec3, u: DVec2, λ: &Wavelengths) -> Option<DirectSample> {
        match (shape, &self.radiance) {
            (Geometry::Patch(patch), AnyTexture::Constant(_)) => {
                self.arriving(p, &patch.sample_area::<false>(u), λ)
            }
            _ if self.radiance.varies() => self.sample_other::<true>(shape, p, u, λ),
            _ => self.sample_other::<false>(shape, p, u, λ),
        }
    }

    /// [`Area::sample`] of what is not an even patch, out of the way of those.
    #[inline(never)]
    fn sample_other<const UV: bool>(
        &self,
        shape: &Geometry,
        p: DVec3,
        u: DVec2,
        λ: &Wavelengths,
    ) -> Option<DirectSample> {
        if let Geometry::Sphere(sphere) = shape
            && let Some(one_minus_cos) = sphere.cone(p)
        {
            let SphereSample { direction: wi, distance, error, n, uv } =
                sphere.sample_cone::<UV>(p, u, one_minus_cos)?;
            let distance = free_way(distance, position_error(p) + error);
            let radiance = Radiance::Known(self.radiance.eval_light(uv, λ));
            return Some(DirectSample {
                wi,
                distance,
                radiance,
                pdf: cone_pdf(one_minus_cos),
                delta: false,
                n,
            });
        }
        self.arriving(p, &shape.sample_area::<UV>(u), λ)
    }

    /// Light that arrives at p from a sampled point; dω = cosθ dA / d².
    #[inline(always)]
    fn arriving(&self, p: DVec3, chosen: &AreaSample, λ: &Wavelengths) -> Option<DirectSample> {
        let towards = chosen.p - p;
        let d2 = towards.length_squared();
        let d = d2.sqrt();
        let wi = towards / d;
        let cos = -wi.dot(chosen.n);
        if !(cos > 0.0 && d2 > 0.0) {
            return None;
        }
        let distance = free_way(d, position_error(p) + chosen.error);
        let radiance = Radiance::Known(self.radiance.eval_light(chosen.uv, λ));
        Some(DirectSample { wi, distance, radiance, pdf: chosen.pdf * d2 / cos, delta: false, n: chosen.n })
    }

    /// The density in sr⁻¹ with which a sample from the ray's origin has its direction, if the ray meets the
    /// surface at `point` after the distance `t`.
    #[inline]
    pub fn pdf(&self, shape: &Geometry, ray: &Ray, t: f64, point: &SurfacePoint) -> f64 {
        if let Geometry::Sphere(sphere) = shape
            && let Some(one_minus_cos) = sphere.cone(ray.origin)
        {
            return cone_pdf(one_minus_cos);
        }
        let cos = -ray.direction.dot(point.ng);
        if cos > 0.0 { t * t / (cos * shape.area()) } else { 0.0 }
    }

    /// Whether the radiance varies over the surface.
    pub fn varies(&self) -> bool {
        self.radiance.varies()
    }

    /// Radiant intensity in W·sr⁻¹·nm⁻¹, the mean over the spectrum, where it is largest: along the normal. A
    /// closed shape shows a quarter of its surface to any direction, on average over directions (Cauchy).
    pub fn intensity(&self, shape: &Geometry, normals: Cone) -> f64 {
        let seen = if normals == Cone::EVERYWHERE { 0.25 } else { 1.0 };
        self.radiance.mean() * shape.area() * seen
    }

    /// The power in W·nm⁻¹ that leaves the surface, the mean over the spectrum.
    pub fn power(&self, shape: &Geometry) -> f64 {
        self.radiance.mean() * shape.area() * std::f64::consts::PI
    }
}
