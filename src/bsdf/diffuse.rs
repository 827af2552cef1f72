//! Lambert's law: light leaves equally in every direction, f = ρ/π.

use super::{Bsdf, Evaluation, Material, Sample, Traits};
use crate::math::{DVec2, DVec3, warp};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{ColorMode, Spectrum, Wavelengths};
use crate::texture::AnyTexture;

/// A one-sided matte surface.
pub struct Diffuse {
    reflectance: AnyTexture,
}

impl Diffuse {
    /// The same reflectance everywhere and for all light.
    pub fn matte(reflectance: f64) -> Self {
        Self { reflectance: AnyTexture::default_value(reflectance, Usage::Reflectance, ColorMode::Spectral) }
    }
}

/// A reflectance at a point.
pub struct DiffuseBsdf {
    reflectance: Spectrum,
}

impl DiffuseBsdf {
    pub fn of(reflectance: Spectrum) -> Self {
        Self { reflectance }
    }
}

impl Material for Diffuse {
    const NAME: &'static str = "diffuse";
    const ABOUT: &'static str =
        "A matte surface that reflects equally into all directions of its front side.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="diffuse"/>"#,
        r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.9, 0.2, 0.1"/></bsdf>"#,
        r#"<bsdf type="diffuse"><spectrum name="reflectance" value="400:0.1, 700:0.9"/></bsdf>"#,
    ];
    const WHITE: &'static [&'static str] = &[
        r#"<bsdf type="twosided"><bsdf type="diffuse"><spectrum name="reflectance" value="1"/></bsdf></bsdf>"#,
    ];
    type Bsdf<'a> = DiffuseBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about = "fraction of light reflected";
        Ok(Self { reflectance: params.texture("reflectance", 0.5, Usage::Reflectance, about)? })
    }

    // Most vertices of most scenes are of this kind, and with many kernels the compiler thinks better of it.
    #[inline(always)]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> DiffuseBsdf {
        DiffuseBsdf { reflectance: self.reflectance.eval(point.uv, λ) }
    }

    fn traits(&self) -> Traits {
        Traits { has_density: true, one_lobe: true, textured: self.reflectance.varies(), ..Traits::default() }
    }
}

impl Bsdf for DiffuseBsdf {
    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let pdf = warp::cosine_hemisphere_pdf(wi);
        Evaluation { value: self.reflectance * pdf as f32, pdf }
    }

    #[inline(always)]
    fn sample(&self, wo: DVec3, _lobe: f64, u: DVec2) -> Option<Sample> {
        let wi = warp::cosine_hemisphere(u);
        let pdf = warp::cosine_hemisphere_pdf(wi);
        (wo.z > 0.0 && pdf > 0.0).then(|| Sample::with_density(wi, self.reflectance, pdf))
    }

    #[inline]
    fn albedo(&self) -> Option<Spectrum> {
        Some(self.reflectance)
    }
}
