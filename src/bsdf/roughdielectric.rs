//! A rough interface between two transparent materials (Walter et al. 2007).
//!
//! Reflection at facets half-way between the directions, refraction at facets along the generalised half
//! vector h = ωo + ηωi, whose Jacobian is η²|ωi·m|/|h|² because ωo·m + ηωi·m = ±|h|.

use super::microfacet::{Distribution, reflect};
use super::roughness::Roughness;
use super::sides::{relative_eta, upward};
use super::tints::Tints;
use super::{Bsdf, Evaluation, Material, Sample, Traits, fresnel, ior};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// An interface of ground glass.
pub struct RoughDielectric {
    /// η inside / η outside.
    eta: f64,
    roughness: Roughness,
    tints: Tints,
}

/// Ground glass at a point.
pub struct RoughDielectricBsdf {
    eta: f64,
    facets: Distribution,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

impl Material for RoughDielectric {
    const NAME: &'static str = "roughdielectric";
    const ABOUT: &'static str = "Ground or frosted glass: microfacets that reflect and refract.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="roughdielectric"/>"#,
        r#"<bsdf type="roughdielectric">
            <string name="distribution" value="ggx"/><float name="alpha" value="0.3"/>
            <float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>
        </bsdf>"#,
        r#"<bsdf type="roughdielectric">
            <float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.5"/>
            <rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/>
            <rgb name="specular_transmittance" value="0.7, 0.8, 0.9"/>
        </bsdf>"#,
        r#"<bsdf type="roughdielectric">
            <string name="distribution" value="ggx"/><float name="alpha_u" value="0.4"/><float name="alpha_v" value="0.15"/>
            <float name="int_ior" value="1"/><float name="ext_ior" value="1.7"/>
        </bsdf>"#,
        r#"<bsdf type="roughdielectric">
            <string name="int_ior" value="water"/><float name="alpha" value="0.5"/>
            <boolean name="sample_visible" value="false"/>
        </bsdf>"#,
        r#"<bsdf type="roughdielectric">
            <string name="int_ior" value="diamond"/><string name="distribution" value="ggx"/>
            <float name="alpha" value="0.25"/><boolean name="sample_visible" value="false"/>
        </bsdf>"#,
    ];
    type Bsdf<'a> = RoughDielectricBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let eta = ior::relative(params, "bk7")?;
        ior::refuse_equal(params, eta)?;
        Ok(Self { eta, roughness: Roughness::parse(params)?, tints: Tints::parse(params)? })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> RoughDielectricBsdf {
        let [reflectance, transmittance] = self.tints.at(point, λ);
        RoughDielectricBsdf { eta: self.eta, facets: self.roughness.at(point.uv), reflectance, transmittance }
    }

    fn traits(&self) -> Traits {
        Traits {
            has_density: true,
            glossy: self.roughness.narrow(),
            anisotropic: self.roughness.anisotropic(),
            textured: self.roughness.varies() || self.tints.varies(),
            transmits: true,
            ..Traits::default()
        }
    }
}

impl RoughDielectricBsdf {
    /// Value and density, both without tint, for directions with wo.z > 0 that meet at a facet `m`; `eta` =
    /// η far / η near.
    #[inline]
    fn at_facet(&self, wo: DVec3, wi: DVec3, m: DVec3, eta: f64) -> (f64, f64) {
        let (o, i) = (wo.dot(m), wi.dot(m));
        // Light does not cross from the back of a facet, nor leave to the other side of the surface than of
        // the facet.
        if o <= 0.0 || i * wi.z <= 0.0 {
            return (0.0, 0.0);
        }
        let face = fresnel::dielectric(o, eta);
        let (shown, drawn) = self.facets.shown_and_drawn_widened(wo, wi, m);
        if wi.z > 0.0 {
            return (face.reflectance * shown / (4.0 * wo.z), face.reflectance * drawn / (4.0 * o));
        }
        let h = o + eta * i;
        let jacobian = -i / (h * h);
        // η² of the Jacobian is not in the value, because radiance carries 1/η².
        (face.transmittance * shown * o * jacobian / wo.z, face.transmittance * drawn * eta * eta * jacobian)
    }

    #[inline]
    fn tint(&self, wi: DVec3) -> Spectrum {
        if wi.z > 0.0 { self.reflectance } else { self.transmittance }
    }
}

impl Bsdf for RoughDielectricBsdf {
    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if wo.z == 0.0 || wi.z == 0.0 {
            return Evaluation::ZERO;
        }
        // A surface seen from inside is that seen from outside with the indices exchanged.
        let eta = relative_eta(self.eta, wo);
        let (wo, wi) = (upward(wo, wo), upward(wi, wo));
        let h = if wi.z > 0.0 { wo + wi } else { wo + wi * eta };
        let m = unit(if h.z < 0.0 { -h } else { h });
        let (value, pdf) = self.at_facet(wo, wi, m, eta);
        Evaluation { value: self.tint(wi) * value as f32, pdf }
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        if wo.z == 0.0 {
            return None;
        }
        let (eta, viewer) = (relative_eta(self.eta, wo), wo);
        let wo = upward(wo, viewer);
        let m = self.facets.widened(wo.z).sample(wo, u);
        let cos = wo.dot(m);
        if cos <= 0.0 {
            return None;
        }
        let reflected = lobe < fresnel::dielectric(cos, eta).reflectance;
        let wi = if reflected { reflect(wo, m) } else { fresnel::refract(wo, m, cos, eta)? };
        // A facet may scatter light into its own surface.
        if wi.z == 0.0 || (wi.z > 0.0) != reflected {
            return None;
        }
        let (value, pdf) = self.at_facet(wo, wi, m, eta);
        let sample = Sample::with_density(upward(wi, viewer), self.tint(wi) * (value / pdf) as f32, pdf);
        (pdf > 0.0).then_some(Sample { eta: if reflected { 1.0 } else { eta }, ..sample })
    }
}
