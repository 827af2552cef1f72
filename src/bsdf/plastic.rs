//! A diffuse base under a smooth dielectric coat, with light that goes back and forth in the coat summed in
//! closed form.

use super::coat::{Coat, Coated};
use super::fresnel::Refraction;
use super::{Bsdf, Evaluation, Material, Sample, Traits, fresnel, mirror};
use crate::math::{DVec2, DVec3, warp};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;

/// Shiny plastic, varnished wood, glazed pottery.
pub struct Plastic {
    coat: Coat,
    /// The coat's reflectance for diffuse light from inside.
    internal: f64,
}

/// Plastic at a point.
pub struct PlasticBsdf {
    coat: Coated,
}

impl Material for Plastic {
    const NAME: &'static str = "plastic";
    const ABOUT: &'static str = "Shiny plastic: a matte base under a smooth transparent coat.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="plastic"/>"#,
        r#"<bsdf type="plastic">
            <rgb name="diffuse_reflectance" value="0.1, 0.27, 0.36"/><float name="int_ior" value="1.9"/>
        </bsdf>"#,
        r#"<bsdf type="plastic">
            <rgb name="diffuse_reflectance" value="0.9, 0.5, 0.2"/><boolean name="nonlinear" value="true"/>
            <rgb name="specular_reflectance" value="0.5, 0.8, 0.6"/>
        </bsdf>"#,
        r#"<bsdf type="plastic"><float name="int_ior" value="1.3"/><string name="ext_ior" value="water"/></bsdf>"#,
    ];
    type Bsdf<'a> = PlasticBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let coat = Coat::parse(params)?;
        let internal = fitted_diffuse_reflectance(1.0 / coat.eta);
        let why = "the fit of what the coat reflects inwards exceeds 1";
        coat.require_sum(params, internal, why, "expected a ratio of indices up to 3.8")?;
        Ok(Self { coat, internal })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> PlasticBsdf {
        PlasticBsdf { coat: self.coat.at(point, λ, self.internal) }
    }

    fn traits(&self) -> Traits {
        Traits { has_density: true, textured: self.coat.varies(), ..Traits::default() }
    }
}

/// The integral that [`fresnel::diffuse_reflectance`] computes, by the fits that Mitsuba's image has: Egan
/// and Hilgeman (1973) below η = 1 and d'Eon and Irving (2011, "A Quantized-Diffusion Model") above, within
/// 0.2 % for glasses.
fn fitted_diffuse_reflectance(eta: f64) -> f64 {
    let x = 1.0 / eta;
    if eta < 1.0 {
        return 0.0636 * x + eta * (eta * -1.4399 + 0.7099) + 0.6681;
    }
    0.919317 + x * (-3.4793 + x * (6.75335 + x * (-7.80989 + x * (4.98554 + x * -1.36881))))
}

impl PlasticBsdf {
    #[inline]
    fn face(&self, w: DVec3) -> Refraction {
        fresnel::dielectric(w.z, self.coat.eta)
    }
}

impl Bsdf for PlasticBsdf {
    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let (into, out_of) = (self.face(wi), self.face(wo));
        let cosine = warp::cosine_hemisphere_pdf(wi);
        let (_, diffuse) = self.coat.lobes(out_of.reflectance, out_of.transmittance);
        let value = self.coat.base * (cosine * into.transmittance * out_of.transmittance) as f32;
        Evaluation { value, pdf: cosine * diffuse }
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        if wo.z <= 0.0 {
            return None;
        }
        let out_of = self.face(wo);
        let (specular, diffuse) = self.coat.lobes(out_of.reflectance, out_of.transmittance);
        if lobe < specular {
            let weight = self.coat.specular * (out_of.reflectance / specular) as f32;
            return Some(Sample::delta(mirror(wo), weight, specular, 1.0));
        }
        let wi = warp::cosine_hemisphere(u);
        let pdf = warp::cosine_hemisphere_pdf(wi) * diffuse;
        let weight = self.coat.base * (self.face(wi).transmittance * out_of.transmittance / diffuse) as f32;
        (pdf > 0.0).then(|| Sample::with_density(wi, weight, pdf))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_are_near_the_integral() {
        for i in 0..=100 {
            let eta = 1.01 + 0.01 * i as f64;
            for (eta, tolerance) in [(eta, 0.001), (1.0 / eta, 0.001)] {
                let (fit, exact) = (fitted_diffuse_reflectance(eta), fresnel::diffuse_reflectance(eta));
                assert!((fit - exact).abs() < tolerance, "{eta} {fit} {exact}");
            }
        }
    }
}
