//! A mixture of two materials.

use super::{AnyMaterial, Bsdf, Evaluation, Lobe, Material, Sample, Traits, rescale};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;

/// Two materials and the share of the second.
pub struct Blend {
    weight: AnyTexture,
    nested: [Box<AnyMaterial>; 2],
}

/// A mixture at a point.
pub struct BlendBsdf<'a> {
    /// The share of the second material.
    weight: f64,
    nested: &'a [Box<AnyMaterial>; 2],
    point: &'a SurfacePoint,
    λ: &'a Wavelengths,
}

impl Material for Blend {
    const NAME: &'static str = "blendbsdf";
    const ABOUT: &'static str = "A mixture of two materials, side by side below what the eye resolves.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="blendbsdf">
            <float name="weight" value="0.3"/>
            <bsdf type="diffuse"/><bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>
        </bsdf>"#,
        r#"<bsdf type="blendbsdf">
            <float name="weight" value="0.75"/><bsdf type="conductor"/><bsdf type="diffuse"/>
        </bsdf>"#,
        r#"<bsdf type="blendbsdf">
            <texture name="weight" type="checkerboard">
                <float name="color0" value="0.2"/><float name="color1" value="0.9"/>
            </texture>
            <bsdf type="roughplastic"><float name="alpha" value="0.25"/></bsdf>
            <bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>
        </bsdf>"#,
        r#"<bsdf type="blendbsdf">
            <float name="weight" value="1"/><bsdf type="diffuse"/><bsdf type="plastic"/>
        </bsdf>"#,
    ];
    const WHITE: &'static [&'static str] = &[
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.3"/><bsdf type="dielectric"/><bsdf type="twosided">
            <bsdf type="diffuse"><spectrum name="reflectance" value="1"/></bsdf></bsdf></bsdf>"#,
    ];
    type Bsdf<'a> = BlendBsdf<'a>;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about = "share of the second material: 0 is the first alone, 1 the second";
        let weight = params.optional_texture("weight", Usage::Reflectance, about)?;
        let weight = weight
            .ok_or_else(|| SceneError::at(&params.element.span, "there is no `weight`", "add one"))?
            .scalar();
        let [first, second] = params.objects("bsdf", "the two materials")[..] else {
            return Err(SceneError::at(
                &params.element.span,
                "a blend of other than two materials",
                "expected two",
            ));
        };
        let nested = [AnyMaterial::parse(first, params.loader)?, AnyMaterial::parse(second, params.loader)?];
        Ok(Self { weight, nested: nested.map(Box::new) })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> BlendBsdf<'a> {
        BlendBsdf {
            weight: self.weight.eval_scalar(point.uv).clamp(0.0, 1.0),
            nested: &self.nested,
            point,
            λ,
        }
    }

    fn traits(&self) -> Traits {
        let own = Traits { textured: self.weight.varies(), ..Traits::default() };
        self.nested[0].traits().or(self.nested[1].traits()).or(own)
    }
}

impl BlendBsdf<'_> {
    /// One material's part of the mixture.
    #[inline]
    fn part(&self, index: usize, share: f64, wo: DVec3, wi: DVec3) -> Evaluation {
        if share == 0.0 {
            return Evaluation::ZERO;
        }
        let Evaluation { value, pdf } = self.nested[index].at(self.point, self.λ).evaluate(wo, wi);
        Evaluation { value: value * share as f32, pdf: pdf * share }
    }
}

impl Bsdf for BlendBsdf<'_> {
    /// That of the material that reflects more in its lobe.
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        let part = |index: usize, weight: f64| {
            let lobe = self.nested[index].at(self.point, self.λ).lobe(wo);
            Lobe { share: weight * lobe.share, ..lobe }
        };
        let (a, b) = (part(0, 1.0 - self.weight), part(1, self.weight));
        if a.share < b.share { b } else { a }
    }

    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        let (a, b) = (self.part(0, 1.0 - self.weight, wo, wi), self.part(1, self.weight, wo, wi));
        Evaluation { value: a.value + b.value, pdf: a.pdf + b.pdf }
    }

    #[inline]
    fn null_transmission(&self, wo: DVec3) -> Spectrum {
        let [first, second] = [0, 1].map(|i| self.nested[i].at(self.point, self.λ).null_transmission(wo));
        first * (1.0 - self.weight) as f32 + second * self.weight as f32
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        let (index, share, lobe) = if lobe < self.weight {
            (1, self.weight, rescale(lobe, 0.0, self.weight))
        } else {
            (0, 1.0 - self.weight, rescale(lobe, self.weight, 1.0))
        };
        let sample = self.nested[index].at(self.point, self.λ).sample(wo, lobe, u)?;
        let own = sample.pdf * share;
        if sample.delta {
            // The share is in the coefficient and in the probability.
            return Some(Sample { pdf: own, ..sample });
        }
        let other = self.part(1 - index, 1.0 - share, wo, sample.wi);
        let pdf = own + other.pdf;
        let weight = sample.weight * (own / pdf) as f32 + other.value * (1.0 / pdf) as f32;
        Some(Sample { weight, pdf, ..sample })
    }
}
