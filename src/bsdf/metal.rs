//! The reflectance of a metal: the parameters that `conductor` and `roughconductor` share.

use super::fresnel;
use super::tints::tint;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::table::Tabulated;
use crate::spectrum::{ColorMode, SpectralFunction, Spectrum, Wavelengths, materials};
use crate::texture::AnyTexture;
use std::sync::Arc;

/// A complex index of refraction, and a factor of the reflectance.
pub struct Metal {
    /// η and k; absent for a perfect mirror.
    index: Option<(AnyTexture, AnyTexture)>,
    reflectance: AnyTexture,
}

/// A metal at a point.
pub struct Reflector {
    index: Option<(Spectrum, Spectrum)>,
    reflectance: Spectrum,
}

impl Metal {
    /// Reads `material`, or `eta` and `k`, and `specular_reflectance`.
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about = "a measured metal by its symbol, or `none` for a perfect mirror";
        let name = params.string("material", about)?.filter(|name| name.value != "none");
        let (has_eta, has_k) = (params.has("eta"), params.has("k"));
        let eta = params.texture("eta", 0.0, Usage::Unbounded, "real part of the index of refraction")?;
        let k = params.texture("k", 1.0, Usage::Unbounded, "imaginary part of the index of refraction")?;
        let index = match name {
            Some(_) if has_eta || has_k => {
                let given = if has_eta { "eta" } else { "k" };
                return Err(params.error(
                    given,
                    format!("`{given}` beside `material`"),
                    "expected one of the two",
                ));
            }
            Some(name) => {
                let (eta, k) = materials::conductor(&name.value).map_err(|help| {
                    SceneError::at(&name.value_span, format!("unknown material `{}`", name.value), help)
                })?;
                Some((measured(eta, params.loader.mode), measured(k, params.loader.mode)))
            }
            None if has_eta || has_k => Some((eta, k)),
            None => None,
        };
        let reflectance = tint(params, "specular_reflectance", "factor upon the reflection; physically 1")?;
        Ok(Self { index, reflectance })
    }

    #[inline(always)]
    pub fn at(&self, point: &SurfacePoint, λ: &Wavelengths) -> Reflector {
        let index = self.index.as_ref().map(|(eta, k)| (eta.eval(point.uv, λ), k.eval(point.uv, λ)));
        Reflector { index, reflectance: self.reflectance.eval(point.uv, λ) }
    }

    pub fn varies(&self) -> bool {
        let index = self.index.as_ref().is_some_and(|(eta, k)| eta.varies() || k.varies());
        index || self.reflectance.varies()
    }
}

/// A measured index: in RGB mode the colour that its table has as a light, which is what Mitsuba takes.
fn measured(table: Tabulated, mode: ColorMode) -> AnyTexture {
    AnyTexture::Constant(match mode {
        ColorMode::Spectral => SpectralFunction::Table(Arc::new(table)),
        ColorMode::Rgb => SpectralFunction::Rgb(materials::in_rgb(&table)),
    })
}

impl Reflector {
    /// The share reflected at an angle with cosine `cos`.
    #[inline]
    pub fn reflectance(&self, cos: f64) -> Spectrum {
        let Some((eta, k)) = self.index else { return self.reflectance };
        let fresnel = |i| fresnel::conductor(cos, eta.0[i] as f64, k.0[i] as f64) as f32;
        self.reflectance * Spectrum::from_fn(fresnel)
    }
}
