//! What principled models have of a matte base: its colour, which may tint other lobes, and its lobe.

use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;
use std::f64::consts::FRAC_1_PI;

/// The colour of a base.
pub struct Base {
    color: AnyTexture,
    /// Its luminance, if that does not vary.
    luminance: Option<f64>,
}

impl Base {
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let color = params.texture("base_color", 0.5, Usage::Reflectance, "colour of the material")?;
        let luminance = (!color.varies()).then(|| color.luminance(SurfacePoint::flat().uv));
        Ok(Self { color, luminance })
    }

    /// The colour, and the same over its luminance, which is 1 where nothing is tinted.
    pub fn at(&self, point: &SurfacePoint, λ: &Wavelengths, tints: bool) -> [Spectrum; 2] {
        let color = self.color.eval(point.uv, λ);
        let luminance = || self.luminance.unwrap_or_else(|| self.color.luminance(point.uv));
        let hue = match tints.then(luminance) {
            Some(luminance) if luminance > 0.0 => color * (1.0 / luminance) as f32,
            _ => Spectrum::ONE,
        };
        [color, hue]
    }

    pub fn varies(&self) -> bool {
        self.color.varies()
    }
}

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
        let (o, i) = (fifth(cos_o), fifth(cos_i));
        let retro = 2.0 * self.roughness * cos_d * cos_d;
        let rough = (1.0 - 0.5 * o) * (1.0 - 0.5 * i) + retro * (o + i + o * i * (retro - 1.0));
        let towards = |weight: f64| 1.0 + (0.5 * retro - 1.0) * weight;
        let below = 1.25 * (towards(o) * towards(i) * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
        let matte = self.share * (rough + (below - rough) * self.flatness);
        self.color * (matte * FRAC_1_PI * cos_i) as f32 + self.sheen * (fifth(cos_d) * cos_i) as f32
    }
}

/// (1 − cos θ)⁵.
pub fn fifth(cos: f64) -> f64 {
    let rest = (1.0 - cos).clamp(0.0, 1.0);
    rest * rest * (rest * rest) * rest
}

/// Schlick's approximation, from the reflectance at normal incidence and (1 − cos θ)⁵.
pub fn schlick(r0: Spectrum, weight: f64) -> Spectrum {
    r0 * (1.0 - weight) as f32 + Spectrum::splat(weight as f32)
}

/// Roughness α along and across the tangent, of a roughness and an anisotropy from 0 to 1 (Burley 2012,
/// section 5.4).
pub fn alphas(roughness: f64, anisotropic: f64) -> [f64; 2] {
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    [roughness * roughness / aspect, roughness * roughness * aspect].map(|a| a.max(1e-3))
}
