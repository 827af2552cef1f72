//! The principled model at a point.

use super::Gtr1;
use super::matte::{Matte, schlick};
use crate::bsdf::fresnel::schlick_weight;
use crate::bsdf::microfacet::{Distribution, Shape, reflect};
use crate::bsdf::sides::{relative_eta, upward};
use crate::bsdf::{Bsdf, Evaluation, Lobe, Sample, fresnel, rescale};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, warp};
use crate::spectrum::Spectrum;

/// All lobes at a point.
pub struct PrincipledBsdf {
    /// The diffuse base with its sheen. What neither it nor `clear` takes is metal.
    pub matte: Matte,
    /// Colour of the base over its luminance; 1 where nothing is tinted.
    pub hue: Spectrum,
    pub facets: Distribution,
    /// η inside / η outside.
    pub eta: f64,
    pub metallic: f64,
    pub spec_tint: f64,
    pub clearcoat: f64,
    pub coat: Gtr1,
    /// Share of what reflects and transmits like glass.
    pub clear: f64,
    /// Probabilities of sampling the matte lobe and the coat, seen from outside.
    pub chances: [f64; 2],
    /// Probability of sampling the microfacets.
    pub specular_chance: f64,
}

/// Two directions above or through the surface, with the viewer above it, and the facet at which they meet.
struct Meeting {
    wo: DVec3,
    wi: DVec3,
    m: DVec3,
    /// η far / η near, from where the viewer is.
    eta: f64,
    face: fresnel::Refraction,
}

impl Meeting {
    /// From any two directions: a viewer below the surface counts as one above it, with the indices
    /// exchanged.
    fn new(wo: DVec3, wi: DVec3, eta: f64) -> Self {
        let eta = relative_eta(eta, wo);
        let (wo, wi) = (upward(wo, wo), upward(wi, wo));
        let h = if wi.z > 0.0 { wo + wi } else { wo + wi * eta };
        Self::at(wo, wi, unit(if h.z < 0.0 { -h } else { h }), eta)
    }

    /// From a viewer above the surface, with the facet known.
    fn at(wo: DVec3, wi: DVec3, m: DVec3, eta: f64) -> Self {
        Self { wo, wi, m, eta, face: fresnel::dielectric(wo.dot(m).max(0.0), eta) }
    }
}

impl PrincipledBsdf {
    /// (1 − cos θ)⁵ for Schlick's approximation, with the angle on the thinner side.
    fn schlick_weight(&self, at: &Meeting) -> f64 {
        schlick_weight(if at.eta > 1.0 { at.wo.dot(at.m) } else { at.face.cos_transmitted })
    }

    /// Reflectance of microfacets for light from outside: exactly as glass, by Schlick's approximation where
    /// it has a colour.
    fn fresnel(&self, at: &Meeting) -> Spectrum {
        let reflectance = at.face.reflectance;
        // As in Mitsuba, where the index is that of outside there is no interface, of metal neither.
        if reflectance == 0.0 {
            return Spectrum::ZERO;
        }
        let weight = self.schlick_weight(at);
        let r0 = (at.eta - 1.0) / (at.eta + 1.0);
        let [metal, tinted] = [self.metallic, (1.0 - self.metallic) * self.spec_tint];
        Spectrum::splat(((1.0 - self.metallic) * (1.0 - self.spec_tint) * reflectance) as f32)
            + schlick(self.matte.color, weight) * metal as f32
            + schlick(self.hue * (r0 * r0) as f32, weight) * tinted as f32
    }

    /// The clear coat. Its masking is that of a roughness of ½, whatever its own (Burley 2012, section 5.6),
    /// and it is not divided by 4 cos θo cos θi.
    fn coat(&self, at: &Meeting) -> f64 {
        if self.clearcoat == 0.0 {
            return 0.0;
        }
        let masking = Distribution::new(Shape::Ggx, 0.25, 0.25);
        let reflectance = 0.04 + 0.96 * self.schlick_weight(at);
        let shown = self.coat.density(at.m) * masking.masking(at.wo, at.m) * masking.masking(at.wi, at.m);
        0.25 * self.clearcoat * reflectance * shown * at.wi.z
    }

    fn reflection(&self, at: &Meeting, outside: bool) -> Evaluation {
        let (shown, drawn) = self.facets.reflection(at.wo, at.wi, at.m);
        if !outside {
            let reflectance = at.face.reflectance;
            let value = Spectrum::splat((self.clear * reflectance * shown) as f32);
            return Evaluation { value, pdf: reflectance * drawn };
        }
        let [diffuse, coat] = self.chances;
        let specular = self.specular_chance * (1.0 - self.clear * at.face.transmittance);
        let matte = self.matte.value([at.wo.z, at.wi.z], at.wi.dot(at.m));
        let cos = at.wo.dot(at.m);
        let of_coat = if cos > 0.0 { self.coat.pdf(at.m) / (4.0 * cos) } else { 0.0 };
        Evaluation {
            value: self.fresnel(at) * shown as f32 + matte + Spectrum::splat(self.coat(at) as f32),
            pdf: diffuse * warp::cosine_hemisphere_pdf(at.wi) + coat * of_coat + specular * drawn,
        }
    }

    fn transmission(&self, at: &Meeting, outside: bool) -> Evaluation {
        let (o, i) = (at.wo.dot(at.m), at.wi.dot(at.m));
        // Light does not cross from the back of a facet, nor leave to the side of the surface that the facet
        // does not face.
        if o <= 0.0 || i >= 0.0 {
            return Evaluation::ZERO;
        }
        let h = o + at.eta * i;
        let jacobian = -i / (h * h);
        let (shown, drawn) = self.facets.shown_and_drawn(at.wo, at.wi, at.m);
        // η² of the Jacobian is not in the value, because radiance carries 1/η².
        let value = self.clear * at.face.transmittance * shown * o * jacobian / at.wo.z;
        let chance = if outside { self.specular_chance * self.clear } else { 1.0 };
        let drawn = drawn * at.eta * at.eta * jacobian;
        Evaluation {
            value: self.matte.color.map(f32::sqrt) * value as f32,
            pdf: chance * at.face.transmittance * drawn,
        }
    }

    /// All lobes, seen from outside or from inside.
    fn lobes(&self, at: &Meeting, outside: bool) -> Evaluation {
        match at.wi.z > 0.0 {
            true => self.reflection(at, outside),
            false if self.clear > 0.0 => self.transmission(at, outside),
            false => Evaluation::ZERO,
        }
    }

    /// Whether any lobe scatters towards the side that `wo` is on.
    fn shows(&self, wo: DVec3) -> bool {
        wo.z > 0.0 || wo.z < 0.0 && self.clear > 0.0
    }
}

impl Bsdf for PrincipledBsdf {
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        let reflected = fresnel::dielectric(wo.z.abs(), self.eta).reflectance;
        let share = self.metallic + (1.0 - self.metallic) * (1.0 - self.clear) * reflected;
        Lobe::of_facets(wo, self.facets.alpha(), share)
    }

    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        if !self.shows(wo) || wi.z == 0.0 {
            return Evaluation::ZERO;
        }
        self.lobes(&Meeting::new(wo, wi, self.eta), wo.z > 0.0)
    }

    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        if !self.shows(wo) {
            return None;
        }
        let (viewer, wo, eta) = (wo, upward(wo, wo), relative_eta(self.eta, wo));
        let outside = viewer.z > 0.0;
        let [diffuse, coat] = if outside { self.chances } else { [0.0; 2] };
        let above = |wi: DVec3| Meeting::at(wo, wi, unit(wo + wi), eta);
        let (at, reflected) = if lobe < diffuse {
            (above(warp::cosine_hemisphere(u)), true)
        } else if lobe < diffuse + coat {
            (above(reflect(wo, self.coat.sample(u))), true)
        } else {
            // The choice among facets' lobes must not depend on other lobes' directions, or the density would
            // be an integral.
            let m = self.facets.sample(wo, u);
            let cos = wo.dot(m);
            let share = if outside { self.clear } else { 1.0 };
            let through = share * fresnel::dielectric(cos.max(0.0), eta).transmittance;
            let reflected = rescale(lobe, diffuse + coat, 1.0) >= through;
            let wi = if reflected { reflect(wo, m) } else { fresnel::refract(wo, m, cos, eta)? };
            // The facet is the one that was drawn: where η is next to 1, two directions hardly tell it.
            (Meeting::at(wo, wi, m, eta), reflected)
        };
        // A facet may scatter light into its own surface.
        if at.wi.z == 0.0 || (at.wi.z > 0.0) != reflected {
            return None;
        }
        let Evaluation { value, pdf } = self.lobes(&at, outside);
        let sample = Sample::with_density(upward(at.wi, viewer), value * (1.0 / pdf) as f32, pdf);
        (pdf > 0.0).then_some(Sample { eta: if reflected { 1.0 } else { eta }, ..sample })
    }
}
