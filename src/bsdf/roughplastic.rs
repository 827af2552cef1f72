//! A diffuse base under a rough dielectric coat.

use super::coat::{Coat, Coated};
use super::microfacet::{Distribution, reflect};
use super::roughness::{has_two_roughnesses, parse_shape};
use super::transmittance::{Transmittance, internal_reflectance};
use super::{Bsdf, Evaluation, Lobe, Material, Sample, Traits, fresnel, ior};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, warp};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;

/// Plastic with a satin finish.
pub struct RoughPlastic {
    coat: Coat,
    facets: Distribution,
    /// The coat's transmittance from outside.
    transmittance: Box<Transmittance>,
    /// The coat's reflectance for diffuse light from inside.
    internal: f64,
}

/// Rough plastic at a point.
pub struct RoughPlasticBsdf<'a> {
    coat: Coated,
    facets: Distribution,
    transmittance: &'a Transmittance,
}

impl Material for RoughPlastic {
    const NAME: &'static str = "roughplastic";
    const ABOUT: &'static str = "Satin plastic: a matte base under a rough transparent coat.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="roughplastic"/>"#,
        r#"<bsdf type="roughplastic">
            <string name="distribution" value="ggx"/><float name="alpha" value="0.3"/>
            <rgb name="diffuse_reflectance" value="0.1, 0.27, 0.36"/><float name="int_ior" value="1.9"/>
        </bsdf>"#,
        r#"<bsdf type="roughplastic">
            <float name="alpha" value="0.5"/><boolean name="nonlinear" value="true"/>
            <rgb name="diffuse_reflectance" value="0.9, 0.5, 0.2"/>
            <rgb name="specular_reflectance" value="0.5, 0.8, 0.6"/>
        </bsdf>"#,
        r#"<bsdf type="roughplastic">
            <string name="distribution" value="ggx"/><float name="alpha" value="0.2"/>
            <boolean name="sample_visible" value="false"/>
        </bsdf>"#,
    ];
    type Bsdf<'a> = RoughPlasticBsdf<'a>;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let coat = Coat::parse(params)?;
        ior::refuse_equal(params, coat.eta)?;
        let (shape, visible) = parse_shape(params)?;
        let alpha = roughness(params)?;
        let seen = Distribution::new(shape, alpha, alpha);
        let internal = internal_reflectance(&seen, 1.0 / coat.eta);
        let why = "the coat reflects all diffuse light inwards";
        coat.require_sum(params, internal, why, "expected a smaller ratio of indices")?;
        Ok(Self {
            facets: Distribution::new(shape, alpha, alpha).sampling_visible(visible),
            transmittance: Box::new(Transmittance::new(&seen, coat.eta)),
            internal,
            coat,
        })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> RoughPlasticBsdf<'a> {
        let coat = self.coat.at(point, λ, self.internal);
        RoughPlasticBsdf { coat, facets: self.facets, transmittance: &self.transmittance }
    }

    fn traits(&self) -> Traits {
        Traits { has_density: true, only_rough: true, textured: self.coat.varies(), ..Traits::default() }
    }
}

/// Reads `alpha`, or `alpha_u` and `alpha_v` where they are the same.
fn roughness(params: &mut Params) -> Result<f64, SceneError> {
    let about = "roughness: √2 times the deviation of the facets' slope";
    let both = params.amount("alpha", 0.1, about)?;
    let u = params.amount("alpha_u", both, "roughness along the tangent, instead of `alpha`")?;
    let v = params.amount("alpha_v", both, "roughness across the tangent, which must be that along it")?;
    if has_two_roughnesses(params)? && u != v {
        let message = "this material has the same roughness in all directions";
        return Err(params.error("alpha_v", message, "expected the value of `alpha_u`"));
    }
    Ok(u)
}

impl Bsdf for RoughPlasticBsdf<'_> {
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        let out_of = self.transmittance.at(wo.z);
        let (specular, _) = self.coat.lobes(1.0 - out_of, out_of);
        Lobe::of_facets(wo, self.facets.alpha(), specular)
    }

    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let m = unit(wo + wi);
        let (reflected, drawn) = self.facets.reflection(wo, wi, m);
        let reflected = reflected * fresnel::dielectric(wo.dot(m), self.coat.eta).reflectance;
        let (into, out_of) = (self.transmittance.at(wi.z), self.transmittance.at(wo.z));
        let (specular, diffuse) = self.coat.lobes(1.0 - out_of, out_of);
        let cosine = warp::cosine_hemisphere_pdf(wi);
        Evaluation {
            value: self.coat.specular * reflected as f32 + self.coat.base * (cosine * into * out_of) as f32,
            pdf: specular * drawn + diffuse * cosine,
        }
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        if wo.z <= 0.0 {
            return None;
        }
        let out_of = self.transmittance.at(wo.z);
        let (specular, _) = self.coat.lobes(1.0 - out_of, out_of);
        let wi =
            if lobe < specular { reflect(wo, self.facets.sample(wo, u)) } else { warp::cosine_hemisphere(u) };
        let Evaluation { value, pdf } = self.evaluate(wo, wi);
        (pdf > 0.0).then(|| Sample::with_density(wi, value * (1.0 / pdf) as f32, pdf))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::loader::Loader;
    use crate::scene::params::Usage;
    use crate::scene::xml;
    use crate::spectrum::ColorMode;

    fn parsed(numbers: &[(&str, &str)]) -> Result<RoughPlastic, SceneError> {
        let written = |(name, value): &(&str, &str)| format!(r#"<float name="{name}" value="{value}"/>"#);
        let inside: String = numbers.iter().map(written).collect();
        let text = format!(r#"<bsdf version="3.0.0" type="roughplastic">{inside}</bsdf>"#);
        let document = xml::read_text("t", &text)?;
        let loader = Loader::new(&document, ColorMode::Rgb)?;
        let mut params = Params::new(&document.root, &loader, Usage::Reflectance)?;
        RoughPlastic::parse(&mut params)
    }

    #[test]
    fn two_roughnesses_may_be_given_if_they_are_one() {
        let density = |numbers: &[(&str, &str)]| {
            parsed(numbers).map(|plastic| plastic.facets.density(unit(DVec3::new(0.1, 0.2, 1.0))))
        };
        let both = density(&[("alpha_u", "0.3"), ("alpha_v", "0.3")]);
        assert_eq!(both.unwrap(), density(&[("alpha", "0.3")]).unwrap());
        for (numbers, message) in [
            ([("alpha_u", "0.3"), ("alpha_v", "0.2")], "same roughness in all directions"),
            ([("alpha_u", "0.3"), ("alpha", "0.3")], "beside"),
            ([("alpha_v", "0.3"), ("int_ior", "1.6")], "without `alpha_u`"),
        ] {
            let error = density(&numbers).unwrap_err();
            assert!(error.message.contains(message), "{error}");
        }
    }
}
