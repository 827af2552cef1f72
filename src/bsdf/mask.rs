//! Holes: a share of the surface is the nested material, the rest is not there.

use super::{AnyMaterial, Bsdf, Evaluation, Lobe, Material, Sample, Traits, rescale};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;

/// A material with an opacity.
pub struct Mask {
    opacity: AnyTexture,
    nested: Box<AnyMaterial>,
}

/// A material with an opacity, at a point.
pub struct MaskBsdf<'a> {
    opacity: f64,
    nested: &'a AnyMaterial,
    point: &'a SurfacePoint,
    λ: &'a Wavelengths,
}

impl Material for Mask {
    const NAME: &'static str = "mask";
    const ABOUT: &'static str =
        "A material with holes, or a veil of it: opaque only to a share of the light.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="mask"><bsdf type="diffuse"/></bsdf>"#,
        r#"<bsdf type="mask">
            <float name="opacity" value="0.8"/>
            <bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha" value="0.4"/></bsdf></bsdf>
        </bsdf>"#,
        r#"<bsdf type="mask"><float name="opacity" value="0.3"/><bsdf type="plastic"/></bsdf>"#,
        r#"<bsdf type="mask">
            <texture name="opacity" type="checkerboard">
                <float name="color0" value="0"/><float name="color1" value="1"/>
            </texture>
            <bsdf type="diffuse"/>
        </bsdf>"#,
    ];
    const WHITE: &'static [&'static str] = &[r#"<bsdf type="mask"><float name="opacity" value="0.3"/>
            <bsdf type="twosided"><bsdf type="diffuse"><spectrum name="reflectance" value="1"/></bsdf></bsdf></bsdf>"#];
    type Bsdf<'a> = MaskBsdf<'a>;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about = "share of the light that meets the material";
        let opacity = params.texture("opacity", 0.5, Usage::Reflectance, about)?.scalar();
        Ok(Self { opacity, nested: Box::new(AnyMaterial::parse_nested(params)?) })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> MaskBsdf<'a> {
        MaskBsdf {
            opacity: self.opacity.eval_scalar(point.uv).clamp(0.0, 1.0),
            nested: &self.nested,
            point,
            λ,
        }
    }

    fn traits(&self) -> Traits {
        let own =
            Traits { transmits: true, has_null: true, textured: self.opacity.varies(), ..Traits::default() };
        self.nested.traits().or(own)
    }
}

impl Bsdf for MaskBsdf<'_> {
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        self.nested.at(self.point, self.λ).lobe(wo)
    }

    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if self.opacity == 0.0 {
            return Evaluation::ZERO;
        }
        let Evaluation { value, pdf } = self.nested.at(self.point, self.λ).evaluate(wo, wi);
        Evaluation { value: value * self.opacity as f32, pdf: pdf * self.opacity }
    }

    #[inline]
    fn null_transmission(&self, wo: DVec3) -> Spectrum {
        let nested = self.nested.at(self.point, self.λ).null_transmission(wo);
        nested * self.opacity as f32 + Spectrum::splat((1.0 - self.opacity) as f32)
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        if lobe >= self.opacity {
            return Some(Sample::null(wo, Spectrum::ONE, 1.0 - self.opacity));
        }
        let sample = self.nested.at(self.point, self.λ).sample(wo, rescale(lobe, 0.0, self.opacity), u)?;
        Some(Sample { pdf: sample.pdf * self.opacity, ..sample })
    }
}
