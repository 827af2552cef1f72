//! Factors of reflection and transmission that are not physical, but in scene files.

use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;

/// `specular_reflectance` and `specular_transmittance` of an interface.
pub struct Tints {
    pub reflectance: AnyTexture,
    pub transmittance: AnyTexture,
}

impl Tints {
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let of_reflection = "factor upon the reflection; physically 1";
        let of_transmission = "factor upon the transmission; physically 1";
        Ok(Self {
            reflectance: tint(params, "specular_reflectance", of_reflection)?,
            transmittance: tint(params, "specular_transmittance", of_transmission)?,
        })
    }

    /// The factors of reflection and of transmission at a point.
    #[inline]
    pub fn at(&self, point: &SurfacePoint, λ: &Wavelengths) -> [Spectrum; 2] {
        [self.reflectance.eval(point.uv, λ), self.transmittance.eval(point.uv, λ)]
    }

    pub fn varies(&self) -> bool {
        self.reflectance.varies() || self.transmittance.varies()
    }
}

/// Reads a factor that is 1 if nothing is said.
pub fn tint(params: &mut Params, name: &'static str, about: &'static str) -> Result<AnyTexture, SceneError> {
    params.texture(name, 1.0, Usage::Reflectance, about)
}
