//! The matte lobe of the principled models.

use crate::bsdf::fresnel::schlick_weight;
use crate::spectrum::Spectrum;
use std::f64::consts::FRAC_1_PI;

/// A matte lobe and sheen at a point: Burley 2012, section 5.3, with retroreflection as in 2015, equation 4;
/// for `flatness` the fit of 2012 to light from below the surface (after Hanrahan and Krueger 1993).
pub struct Matte {
    pub color: Spectrum,
    /// Colour of the sheen times its amount.
    pub sheen: Spectrum,
    pub roughness: f64,
    pub flatness: f64,
    /// Share of the lobe without the sheen.
    pub share: f64,
}

impl Matte {
    /// f·cos θi for cosines with the normal, and the angle to the half vector.
    pub fn value(&self, [cos_o, cos_i]: [f64; 2], cos_d: f64) -> Spectrum {
        let (o, i) = (schlick_weight(cos_o), schlick_weight(cos_i));
        let retro = 2.0 * self.roughness * cos_d * cos_d;
        let rough = (1.0 - 0.5 * o) * (1.0 - 0.5 * i) + retro * (o + i + o * i * (retro - 1.0));
        let towards = |weight: f64| 1.0 + (0.5 * retro - 1.0) * weight;
        let below = 1.25 * (towards(o) * towards(i) * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
        let matte = self.share * (rough + (below - rough) * self.flatness);
        self.color * (matte * FRAC_1_PI * cos_i) as f32 + self.sheen * (schlick_weight(cos_d) * cos_i) as f32
    }
}

/// Schlick's approximation, from the reflectance at normal incidence and (1 − cos θ)⁵.
pub fn schlick(r0: Spectrum, weight: f64) -> Spectrum {
    r0 * (1.0 - weight) as f32 + Spectrum::splat(weight as f32)
}
