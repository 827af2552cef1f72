//! The parameters that the principled models have in common: a base, whose colour may tint other lobes, and how rough
//! it is.

use super::matte::Matte;
use crate::bsdf::microfacet::{Distribution, Shape};
use crate::bsdf::roughness::NARROW;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;

/// The parameters of a base.
pub struct Base {
    color: AnyTexture,
    /// Its luminance, if that does not vary.
    luminance: Option<f64>,
    roughness: AnyTexture,
    anisotropic: AnyTexture,
    sheen: AnyTexture,
    sheen_tint: AnyTexture,
    flatness: AnyTexture,
}

impl Base {
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let color = params.texture("base_color", 0.5, Usage::Reflectance, "colour of the material")?;
        let luminance = (!color.varies()).then(|| color.luminance(SurfacePoint::flat().uv));
        let about = "how far the matte lobe is one of light from below the surface";
        Ok(Self {
            color,
            luminance,
            roughness: share(params, "roughness", 0.5, "square root of the microfacets' α")?,
            anisotropic: share(
                params,
                "anisotropic",
                0.0,
                "how much rougher it is along the tangent than across",
            )?,
            sheen: share(params, "sheen", 0.0, "brightness at grazing, as of cloth")?,
            sheen_tint: share(params, "sheen_tint", 0.0, "how far the sheen has the base's colour")?,
            flatness: share(params, "flatness", 0.0, about)?,
        })
    }

    /// The lobe, with the shares that it and the sheen have; and the colour over its luminance, which is 1
    /// where neither the sheen nor, by `spec_tint`, reflection is tinted.
    pub fn at(
        &self,
        point: &SurfacePoint,
        λ: &Wavelengths,
        [matte, sheen]: [f64; 2],
        spec_tint: f64,
    ) -> (Matte, Spectrum) {
        let color = self.color.eval(point.uv, λ);
        let [of_sheen, sheen_tint] = [&self.sheen, &self.sheen_tint].map(|texture| share_at(texture, point));
        let tints = spec_tint != 0.0 || of_sheen * sheen_tint != 0.0;
        let luminance = || self.luminance.unwrap_or_else(|| self.color.luminance(point.uv));
        let hue = match tints.then(luminance) {
            // Of a smaller one there is no reciprocal.
            Some(luminance) if luminance >= f64::from(f32::MIN_POSITIVE) => color * (1.0 / luminance) as f32,
            _ => Spectrum::ONE,
        };
        let tinted = Spectrum::splat(1.0 - sheen_tint as f32) + hue * sheen_tint as f32;
        let matte = Matte {
            color,
            sheen: tinted * (of_sheen * sheen) as f32,
            roughness: share_at(&self.roughness, point),
            flatness: share_at(&self.flatness, point),
            share: matte,
        };
        (matte, hue)
    }

    /// Facets of this roughness, which are rougher along the tangent than across.
    pub fn facets(&self, point: &SurfacePoint, roughness: f64) -> Distribution {
        let [along, across] = alphas(roughness, share_at(&self.anisotropic, point));
        Distribution::new(Shape::Ggx, along, across)
    }

    /// Whether facets scatter narrowly in either direction, by the same limit as rough metal.
    pub fn narrow(&self) -> bool {
        alphas(self.roughness.mean(), self.anisotropic.mean())[1] < NARROW
    }

    pub fn anisotropic(&self) -> bool {
        self.anisotropic.constant() != Some(0.0)
    }

    pub fn varies(&self) -> bool {
        let all =
            [&self.color, &self.roughness, &self.anisotropic, &self.sheen, &self.sheen_tint, &self.flatness];
        all.iter().any(|texture| texture.varies())
    }
}

/// Reads a parameter from 0 to 1.
pub fn share(
    params: &mut Params,
    name: &'static str,
    default: f64,
    about: &'static str,
) -> Result<AnyTexture, SceneError> {
    params.texture(name, default, Usage::Reflectance, about).map(AnyTexture::scalar)
}

/// The value of such a parameter.
pub fn share_at(texture: &AnyTexture, point: &SurfacePoint) -> f64 {
    texture.eval_scalar(point.uv).clamp(0.0, 1.0)
}

/// Reads how readily a lobe is sampled: never not at all, for it would be lost.
pub fn rate(params: &mut Params, name: &'static str, about: &'static str) -> Result<f64, SceneError> {
    let rate = params.float_where(name, 1.0, about, "no negative number", |rate| rate >= 0.0)?;
    Ok(rate.clamp(0.01, 100.0))
}

/// Roughness α along and across the tangent, of a roughness and an anisotropy from 0 to 1 (Burley 2012,
/// section 5.4).
fn alphas(roughness: f64, anisotropic: f64) -> [f64; 2] {
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    [roughness * roughness / aspect, roughness * roughness * aspect].map(|a| a.max(1e-3))
}
