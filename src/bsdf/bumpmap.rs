//! Normals from heights.

use super::shading_normal::{Adapter, PerturbedBsdf};
use super::{Material, Traits};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::scene::xml::Element;
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;
use crate::texture::AnyTexture;

/// A material, and the heights whose slopes tilt its normal.
pub struct BumpMap {
    heights: AnyTexture,
    /// Factor of heights.
    scale: f64,
    adapter: Adapter,
}

impl Material for BumpMap {
    const NAME: &'static str = "bumpmap";
    const ABOUT: &'static str =
        "A material on a surface whose normals are those of a relief: an image gives its height.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="bumpmap"><texture type="uniform"><float name="value" value="0.5"/></texture><bsdf type="diffuse"/></bsdf>"#,
        r#"<bsdf type="bumpmap"><texture type="uniform"><float name="value" value="0.5"/></texture><float name="scale" value="2"/>
            <bsdf type="roughconductor"><float name="alpha_u" value="0.4"/><float name="alpha_v" value="0.2"/></bsdf></bsdf>"#,
    ];
    // As in `normalmap`.
    const RECIPROCAL: bool = false;
    type Bsdf<'a> = PerturbedBsdf<'a>;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let scale = params.float("scale", 1.0, "factor upon the height, which is in units of the scene")?;
        let about = "the height, whatever the texture's name; a bitmap should be `raw`";
        let element: Option<&Element> = params.object("texture", about)?;
        let adapter = Adapter::parse(params)?;
        let element = element.ok_or_else(|| params.lacks("texture", "expected a bitmap of heights"))?;
        let heights = AnyTexture::parse(element, params.loader, Usage::Vector)?;
        if heights.gradient(DVec2::ZERO).is_none() {
            let message = "this texture has no slope";
            return Err(SceneError::at(&element.span, message, "expected a bitmap, or one number"));
        }
        Ok(Self { heights, scale, adapter })
    }

    /// The normal of the surface p + h·n, without ∂n: (∂p/∂u + n ∂h/∂u) × (∂p/∂v + n ∂h/∂v), with ∂p in the
    /// plane across the shading normal n (Blinn 1978).
    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> PerturbedBsdf<'a> {
        let slope = self.heights.gradient(point.uv).unwrap_or(DVec2::ZERO) * self.scale;
        let n = point.ns;
        let inclined = |tangent: DVec3, slope: f64| tangent + n * (slope - n.dot(tangent));
        let normal = inclined(point.dp_du, slope.x).cross(inclined(point.dp_dv, slope.y));
        let surface = point.frame(true);
        let outward = if normal.dot(point.ng) < 0.0 { -normal } else { normal };
        self.adapter.about(surface.to_local(outward), surface, point, λ)
    }

    fn traits(&self) -> Traits {
        self.adapter.traits(self.heights.varies())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{AnyMaterial, Bsdf};
    use crate::math::frame::{length, unit};
    use crate::scene::loader::Loader;
    use crate::scene::xml;
    use crate::spectrum::ColorMode;

    /// A mirror under the heights of a reference scene, scaled and stretched, reflects straight light about
    /// the normal (−∂h/∂u, −∂h/∂v, 1) of the relief, wherever the geometric normal points.
    #[test]
    fn a_mirror_has_the_normals_of_the_relief() {
        let name = concat!(env!("CARGO_MANIFEST_DIR"), "/validation/references/scenes/example.xml");
        let text = r#"<bsdf version="3.0.0" type="bumpmap"><float name="scale" value="0.2"/>
            <boolean name="use_shadowing_function" value="false"/>
            <texture type="bitmap" name="any"><boolean name="raw" value="true"/>
            <string name="filename" value="textures/heights.png"/></texture>
            <bsdf type="twosided"><bsdf type="conductor"><string name="material" value="none"/></bsdf></bsdf></bsdf>"#;
        let document = xml::read_text(name, text).unwrap();
        let λ = Wavelengths::sample_visible(0.3);
        let loader = Loader::new(&document, ColorMode::Spectral).unwrap();
        let Ok(AnyMaterial::BumpMap(material)) = AnyMaterial::parse(&document.root, &loader) else {
            panic!("no bump map");
        };
        let mut steepest = 0.0f64;
        for i in 0..100 {
            let uv = DVec2::new((i % 10) as f64 / 10.0 + 0.03, (i / 10) as f64 / 10.0 + 0.04);
            let flat = SurfacePoint { uv, dp_dv: DVec3::Y * 3.0, ..SurfacePoint::flat() };
            let slope = material.heights.gradient(uv).unwrap() * 0.2;
            let n = unit(DVec3::new(-slope.x, -slope.y / 3.0, 1.0));
            steepest = steepest.max(slope.length());
            for point in [flat, SurfacePoint { dp_du: -DVec3::X, ..flat }] {
                let n = DVec3::new(n.x * point.dp_du.x, n.y, n.z);
                // Local coordinates: x along the tangent.
                let local = point.frame(true).to_local(n);
                if let Some(sample) = material.at(&point, &λ).sample(DVec3::Z, 0.5, DVec2::splat(0.5)) {
                    assert!(length(sample.wi - (local * (2.0 * local.z) - DVec3::Z)) < 1e-14, "{uv}");
                } else {
                    assert!(local.z * local.z < 0.5, "{uv}");
                }
            }
        }
        assert!(steepest > 0.3, "{steepest}");
    }
}
