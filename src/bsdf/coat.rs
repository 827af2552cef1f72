//! A diffuse base under a dielectric coat: what `plastic` and `roughplastic` share.

use super::ior;
use super::tints::tint;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;

/// The parameters of the base and its coat.
pub struct Coat {
    /// η of the coat / η outside.
    pub eta: f64,
    diffuse: AnyTexture,
    specular: AnyTexture,
    nonlinear: bool,
    /// Weight of the coat's tint against the base's colour when a lobe is chosen.
    specular_weight: f64,
}

/// Base and coat at a point.
pub struct Coated {
    pub eta: f64,
    /// Tint of the coat's reflection.
    pub specular: Spectrum,
    /// ρ/(1 − ρ·Fi)/η²: what the base returns after all orders of reflection inside, taken to the outside.
    pub base: Spectrum,
    specular_weight: f64,
}

impl Coat {
    /// Reads `diffuse_reflectance`, `specular_reflectance`, `nonlinear`, `int_ior` and `ext_ior`.
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let eta = ior::relative(params, "polypropylene")?;
        let about = "fraction of light that the base reflects";
        let diffuse = params.texture("diffuse_reflectance", 0.5, Usage::Reflectance, about)?;
        let specular =
            tint(params, "specular_reflectance", "factor upon the coat's reflection; physically 1")?;
        let about = "let light that stays inside the coat change the base's colour";
        let nonlinear = params.boolean("nonlinear", false, about)?;
        let (d, s) = (diffuse.mean(), specular.mean());
        let specular_weight = if d + s > 0.0 { s / (d + s) } else { 0.5 };
        Ok(Self { eta, diffuse, specular, nonlinear, specular_weight })
    }

    /// `internal` is the coat's reflectance for diffuse light from inside. Without `nonlinear` all colours
    /// lose as much to it as white does.
    #[inline]
    pub fn at(&self, point: &SurfacePoint, λ: &Wavelengths, internal: f64) -> Coated {
        let diffuse = self.diffuse.eval(point.uv, λ);
        let outside = 1.0 / (self.eta * self.eta);
        let base = if self.nonlinear {
            diffuse.map(|d| d * outside as f32 / (1.0 - d * internal as f32))
        } else {
            diffuse * (outside / (1.0 - internal)) as f32
        };
        Coated {
            eta: self.eta,
            specular: self.specular.eval(point.uv, λ),
            base,
            specular_weight: self.specular_weight,
        }
    }

    /// Refuses a share of diffuse light from inside that the coat reflects, `internal`, of which all orders
    /// together have no sum. `why` says so, and `expected` what is possible.
    pub fn require_sum(
        &self,
        params: &Params,
        internal: f64,
        why: &str,
        expected: &str,
    ) -> Result<(), SceneError> {
        if internal < 1.0 {
            return Ok(());
        }
        Err(params.error("int_ior", format!("{why} at η = {}", self.eta), expected))
    }

    pub fn varies(&self) -> bool {
        self.diffuse.varies() || self.specular.varies()
    }
}

impl Coated {
    /// The probabilities of the coat's and the base's lobes, if the coat reflects and transmits these shares
    /// of the light.
    #[inline]
    pub fn lobes(&self, reflected: f64, transmitted: f64) -> (f64, f64) {
        let specular = reflected * self.specular_weight;
        let diffuse = transmitted * (1.0 - self.specular_weight);
        let sum = specular + diffuse;
        if sum > 0.0 { (specular / sum, diffuse / sum) } else { (1.0, 0.0) }
    }
}
