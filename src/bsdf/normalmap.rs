//! Normals from an image.

use super::shading_normal::{Adapter, PerturbedBsdf};
use super::{Material, Traits};
use crate::math::DVec3;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;
use crate::texture::AnyTexture;

/// A material, and the normals about which it works instead of the surface's.
pub struct NormalMap {
    normals: AnyTexture,
    adapter: Adapter,
}

impl Material for NormalMap {
    const NAME: &'static str = "normalmap";
    const ABOUT: &'static str =
        "A material on a surface whose normals an image gives: (x, y, z) are stored as (x + 1)/2 and so on.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="normalmap"><rgb name="normalmap" value="0.5, 0.5, 1"/><bsdf type="diffuse"/></bsdf>"#,
        r#"<bsdf type="normalmap"><rgb name="normalmap" value="0.7, 0.4, 0.9"/>
            <bsdf type="roughplastic"><float name="alpha" value="0.3"/></bsdf></bsdf>"#,
        r#"<bsdf type="normalmap"><rgb name="normalmap" value="0.2, 0.6, 0.85"/>
            <boolean name="flip_invalid_normals" value="false"/>
            <boolean name="use_shadowing_function" value="false"/>
            <bsdf type="roughconductor"><float name="alpha_u" value="0.4"/><float name="alpha_v" value="0.2"/></bsdf></bsdf>"#,
        r#"<bsdf type="normalmap"><rgb name="normalmap" value="0.6, 0.5, 0.95"/><bsdf type="dielectric"/></bsdf>"#,
    ];
    // The cosine is about the perturbed normal for one direction only: f(ω, ω′)·cos/cos is not symmetric
    // (Veach 1997, §5.3.2).
    const RECIPROCAL: bool = false;
    type Bsdf<'a> = PerturbedBsdf<'a>;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about =
            "normals in the frame of the surface, along u, along v and upright; a bitmap should be `raw`";
        let normals = params.optional_texture("normalmap", Usage::Vector, about)?;
        let adapter = Adapter::parse(params)?;
        let normals = normals.ok_or_else(|| {
            SceneError::at(&params.element.span, "there is no `normalmap`", "add a bitmap of that name")
        })?;
        if normals.eval_vector(SurfacePoint::flat().uv).is_none() {
            let expected = "expected a bitmap with three channels";
            return Err(params.error("normalmap", "this texture holds no normals", expected));
        }
        Ok(Self { normals, adapter })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> PerturbedBsdf<'a> {
        let encoded = self.normals.eval_vector(point.uv).unwrap_or(DVec3::new(0.5, 0.5, 1.0));
        self.adapter.about(encoded * 2.0 - 1.0, point.frame(true), point, λ)
    }

    fn traits(&self) -> Traits {
        self.adapter.traits(self.normals.varies())
    }
}
