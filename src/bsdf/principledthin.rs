//! Disney's principled model of thin sheets, such as leaves and paper: matte on both sides, and microfacets
//! that reflect and let through without bending (Burley 2015, "Extending the Disney BRDF to a BSDF with
//! Integrated Subsurface Scattering", section 5.3), in the form that Mitsuba gives it.

use super::fresnel::schlick_weight;
use super::microfacet::{Distribution, reflect};
use super::principled::base::{self, Base, share_at};
use super::principled::matte::{Matte, schlick};
use super::sides::upward;
use super::{Bsdf, Evaluation, Material, Sample, Traits, fresnel, ior};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, warp};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;
use std::f64::consts::FRAC_1_PI;

/// The parameters of the model.
pub struct PrincipledThin {
    base: Base,
    spec_trans: AnyTexture,
    spec_tint: AnyTexture,
    diff_trans: AnyTexture,
    eta: AnyTexture,
    /// Factors of the probabilities of the [lobes](PrincipledThinBsdf::chances), besides the lobes' weights.
    rates: [f64; 4],
}

impl Material for PrincipledThin {
    const NAME: &'static str = "principledthin";
    const ABOUT: &'static str =
        "Disney's model of thin sheets: matte and glassy, with light through both, and sheen.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="principledthin"/>"#,
        r#"<bsdf type="principledthin">
            <rgb name="base_color" value="0.3, 0.6, 0.2"/><float name="diff_trans" value="0.8"/>
            <float name="sheen" value="0.4"/><float name="flatness" value="0.5"/><float name="roughness" value="0.7"/>
        </bsdf>"#,
        r#"<bsdf type="principledthin">
            <rgb name="base_color" value="0.8, 0.7, 0.5"/><float name="spec_trans" value="0.7"/><float name="eta" value="1.4"/>
            <float name="diff_trans" value="1.2"/><float name="roughness" value="0.6"/><float name="anisotropic" value="0.5"/>
            <float name="diffuse_transmittance_sampling_rate" value="2"/><float name="specular_reflectance_sampling_rate" value="0.5"/>
        </bsdf>"#,
        r#"<bsdf type="principledthin">
            <rgb name="base_color" value="0.5, 0.5, 0.5"/><float name="spec_trans" value="0.8"/><float name="spec_tint" value="0.6"/>
            <float name="sheen" value="0.2"/><float name="sheen_tint" value="0.5"/><float name="roughness" value="0.8"/>
        </bsdf>"#,
    ];
    // Light that the mirrored facet's back would face is left out, and which it is depends on the viewer.
    const RECIPROCAL: bool = false;
    type Bsdf<'a> = PrincipledThinBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let base = Base::parse(params)?;
        let mut share = |name, about| base::share(params, name, 0.0, about);
        let spec_trans = share("spec_trans", "share of microfacets; the rest is matte")?;
        let spec_tint = share("spec_tint", "how far reflection has the base's colour")?;
        let about = "twice the share of matte light that goes through";
        let diff_trans = params.texture("diff_trans", 0.0, Usage::Unbounded, about)?.scalar();
        let about = "index of refraction of the sheet over that around it";
        let eta = params.texture("eta", 1.5, Usage::Unbounded, about)?.scalar();
        for (name, texture, range) in [("diff_trans", &diff_trans, 0.0..=2.0), ("eta", &eta, ior::RANGE)] {
            if let Some(value) = texture.constant().filter(|value| !range.contains(value)) {
                let expected = format!("expected {} to {}", range.start(), range.end());
                return Err(params.error(name, format!("{value} is out of range"), expected));
            }
        }
        let mut rate = |name, about| base::rate(params, name, about);
        let rates = [
            rate("diffuse_reflectance_sampling_rate", "how readily matte reflection is sampled")?,
            rate("diffuse_transmittance_sampling_rate", "how readily matte transmission is sampled")?,
            rate("specular_reflectance_sampling_rate", "how readily reflecting facets are sampled")?,
            rate("specular_transmittance_sampling_rate", "how readily transmitting facets are sampled")?,
        ];
        Ok(Self { base, spec_trans, spec_tint, diff_trans, eta, rates })
    }

    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> PrincipledThinBsdf {
        let [specular, spec_tint] =
            [&self.spec_trans, &self.spec_tint].map(|texture| share_at(texture, point));
        let through = 0.5 * self.diff_trans.eval_scalar(point.uv).clamp(0.0, 2.0);
        let eta = self.eta.eval_scalar(point.uv).clamp(*ior::RANGE.start(), *ior::RANGE.end());
        let matte = (1.0 - specular) * (1.0 - through);
        let shares = [matte, (1.0 - specular) * through, 0.5 * specular, 0.5 * specular];
        let weights = [0, 1, 2, 3].map(|lobe| shares[lobe] * self.rates[lobe]);
        let total: f64 = weights.iter().sum();
        let (base, hue) = self.base.at(point, λ, [matte, matte], spec_tint);
        PrincipledThinBsdf {
            reflecting: self.base.facets(point, base.roughness),
            // Light bends twice in the sheet, which blurs it as much as one reflection at such facets
            // (Burley 2015, figure 15).
            transmitting: self.base.facets(point, (0.65 * eta - 0.35) * base.roughness),
            matte: base,
            matte_through: shares[1],
            hue,
            spec_tint,
            specular,
            eta,
            chances: weights.map(|weight| weight / total),
        }
    }

    fn traits(&self) -> Traits {
        let shares = [&self.spec_trans, &self.spec_tint, &self.diff_trans, &self.eta];
        let has_facets = self.spec_trans.constant() != Some(0.0);
        Traits {
            has_density: true,
            transmits: has_facets || self.diff_trans.constant() != Some(0.0),
            glossy: has_facets && self.base.narrow(),
            anisotropic: self.base.anisotropic(),
            textured: self.base.varies() || shares.iter().any(|texture| texture.varies()),
            ..Traits::default()
        }
    }
}

/// A thin sheet at a point: its two sides are alike.
pub struct PrincipledThinBsdf {
    /// What the matte lobe reflects.
    matte: Matte,
    /// Share of matte light that goes through.
    matte_through: f64,
    /// Colour of the base over its luminance; 1 where nothing is tinted.
    hue: Spectrum,
    spec_tint: f64,
    /// Share of the microfacets.
    specular: f64,
    eta: f64,
    reflecting: Distribution,
    transmitting: Distribution,
    /// Probabilities of sampling the lobes: matte reflection and transmission, and those of the microfacets.
    chances: [f64; 4],
}

impl PrincipledThinBsdf {
    /// Reflectance of a facet, in part by Schlick's approximation where that has a colour.
    fn fresnel(&self, cos: f64) -> Spectrum {
        let face = fresnel::dielectric(cos, self.eta);
        let exact = Spectrum::splat((face.reflectance * (1.0 - self.spec_tint)) as f32);
        if self.spec_tint == 0.0 {
            return exact;
        }
        let weight = schlick_weight(if self.eta > 1.0 { cos } else { face.cos_transmitted });
        let r0 = (self.eta - 1.0) / (self.eta + 1.0);
        exact + schlick(self.hue * (r0 * r0) as f32, weight) * self.spec_tint as f32
    }

    /// From a viewer above the sheet, of light from above it.
    fn reflection(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        let m = unit(wo + wi);
        let [matte, _, specular, _] = self.chances;
        let mut value = self.matte.value([wo.z, wi.z], wi.dot(m));
        let mut pdf = matte * warp::cosine_hemisphere_pdf(wi);
        if self.specular > 0.0 {
            let (shown, drawn) = self.reflecting.reflection(wo, wi, m);
            value += self.fresnel(wo.dot(m)) * (self.specular * shown) as f32;
            pdf += specular * drawn;
        }
        Evaluation { value, pdf }
    }

    /// From a viewer above the sheet, of light from below it: as if it was reflected and then turned about
    /// the sheet.
    fn transmission(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        let [_, matte, _, specular] = self.chances;
        let mut value = self.matte.color * (self.matte_through * FRAC_1_PI * -wi.z) as f32;
        let mut pdf = matte * warp::cosine_hemisphere_pdf(-wi);
        let m = unit(wo + turned(wi));
        if self.specular > 0.0 && comes_from_behind(wi, m) {
            let (shown, drawn) = self.transmitting.reflection(wo, wi, m);
            let transmittance = fresnel::dielectric(wo.dot(m), self.eta).transmittance;
            value += self.matte.color * (self.specular * transmittance * shown) as f32;
            pdf += specular * drawn;
        }
        Evaluation { value, pdf }
    }
}

/// Whether light from `wi` can go through a facet to its front.
fn comes_from_behind(wi: DVec3, m: DVec3) -> bool {
    wi.dot(m) < 0.0
}

/// `w` turned about the sheet.
fn turned(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

impl Bsdf for PrincipledThinBsdf {
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if wo.z == 0.0 || wi.z == 0.0 {
            return Evaluation::ZERO;
        }
        let (wo, wi) = (upward(wo, wo), upward(wi, wo));
        if wi.z > 0.0 { self.reflection(wo, wi) } else { self.transmission(wo, wi) }
    }

    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        if wo.z == 0.0 {
            return None;
        }
        let (viewer, wo) = (wo, upward(wo, wo));
        let [matte, through, reflecting, _] = self.chances;
        let (wi, reflected) = if lobe < matte {
            (warp::cosine_hemisphere(u), true)
        } else if lobe < matte + through {
            (turned(warp::cosine_hemisphere(u)), false)
        } else if lobe < matte + through + reflecting {
            (reflect(wo, self.reflecting.sample(wo, u)), true)
        } else {
            let m = self.transmitting.sample(wo, u);
            (Some(turned(reflect(wo, m))).filter(|wi| comes_from_behind(*wi, m))?, false)
        };
        // A facet may scatter light into its own surface.
        if wi.z == 0.0 || (wi.z > 0.0) != reflected {
            return None;
        }
        let Evaluation { value, pdf } =
            if reflected { self.reflection(wo, wi) } else { self.transmission(wo, wi) };
        (pdf > 0.0).then(|| Sample::with_density(upward(wi, viewer), value * (1.0 / pdf) as f32, pdf))
    }
}
