//! A rough metal: f = F·D·G/(4 cos θo cos θi) (Walter et al. 2007, equation 20).

use super::metal::{Metal, Reflector};
use super::microfacet::{Distribution, reflect};
use super::roughness::Roughness;
use super::{Bsdf, Evaluation, Lobe, Material, Sample, Traits};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;

/// A one-sided metal with a rough surface. Light that facets reflect onto other facets is lost.
pub struct RoughConductor {
    metal: Metal,
    roughness: Roughness,
}

/// A rough metal at a point.
pub struct RoughConductorBsdf {
    metal: Reflector,
    facets: Distribution,
}

impl Material for RoughConductor {
    const NAME: &'static str = "roughconductor";
    const ABOUT: &'static str = "A brushed or sand-blasted metal: microfacets that are mirrors of metal.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="roughconductor"/>"#,
        r#"<bsdf type="roughconductor">
            <string name="material" value="Cu"/><string name="distribution" value="ggx"/>
            <float name="alpha" value="0.3"/>
        </bsdf>"#,
        r#"<bsdf type="roughconductor">
            <string name="material" value="Al"/><string name="distribution" value="ggx"/>
            <float name="alpha_u" value="0.15"/><float name="alpha_v" value="0.4"/>
        </bsdf>"#,
        r#"<bsdf type="roughconductor">
            <float name="eta" value="0.2"/><float name="k" value="3.9"/>
            <float name="alpha_u" value="0.5"/><float name="alpha_v" value="0.2"/>
            <rgb name="specular_reflectance" value="0.9, 0.7, 0.5"/>
        </bsdf>"#,
        r#"<bsdf type="roughconductor">
            <float name="alpha" value="0.6"/><boolean name="sample_visible" value="false"/>
        </bsdf>"#,
        r#"<bsdf type="roughconductor">
            <string name="distribution" value="ggx"/><float name="alpha" value="0.3"/>
            <boolean name="sample_visible" value="false"/>
        </bsdf>"#,
    ];
    type Bsdf<'a> = RoughConductorBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        Ok(Self { metal: Metal::parse(params)?, roughness: Roughness::parse(params)? })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> RoughConductorBsdf {
        RoughConductorBsdf { metal: self.metal.at(point, λ), facets: self.roughness.at(point.uv) }
    }

    fn traits(&self) -> Traits {
        Traits {
            has_density: true,
            one_lobe: true,
            only_rough: true,
            glossy: self.roughness.narrow(),
            anisotropic: self.roughness.anisotropic(),
            textured: self.metal.varies() || self.roughness.varies(),
            ..Traits::default()
        }
    }
}

impl Bsdf for RoughConductorBsdf {
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        Lobe::of_facets(wo, self.facets.alpha(), 1.0)
    }

    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let m = unit(wo + wi);
        let (value, pdf) = self.facets.reflection(wo, wi, m);
        Evaluation { value: self.metal.reflectance(wo.dot(m)) * value as f32, pdf }
    }

    #[inline]
    fn sample(&self, wo: DVec3, _lobe: f64, u: DVec2) -> Option<Sample> {
        if wo.z <= 0.0 {
            return None;
        }
        let m = self.facets.sample(wo, u);
        let wi = reflect(wo, m);
        let (value, pdf) = self.facets.reflection(wo, wi, m);
        let usable = wi.z > 0.0 && pdf > 0.0;
        usable
            .then(|| Sample::with_density(wi, self.metal.reflectance(wo.dot(m)) * (value / pdf) as f32, pdf))
    }
}
