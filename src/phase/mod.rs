//! Phase functions: how a medium scatters light, as densities over the sphere.
//!
//! *How to add one*: write `phase/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line to
//! [`PHASES`] and a variant to [`AnyPhase`]. The contract tests follow from the registry.

mod hg;
mod isotropic;
mod rayleigh;

#[cfg(test)]
mod contract;

use crate::bsdf::{Bsdf, Evaluation, Sample};
use crate::math::function::sin_cos_turn;
use crate::math::{DVec2, DVec3};
use crate::scene::registry::Entry;
use crate::spectrum::Spectrum;
pub use hg::HenyeyGreenstein;
pub use isotropic::Isotropic;
pub use rayleigh::Rayleigh;

/// Any phase function.
///
/// As a [`Bsdf`] it works in any frame whose third axis is ωo, the direction to where the light goes, and has
/// no cosine: `value` is p(cos θ) in sr⁻¹, θ being the angle by which light is turned, so that 0 is straight
/// on.
#[derive(Clone, Debug)]
pub enum AnyPhase {
    Isotropic(Isotropic),
    HenyeyGreenstein(HenyeyGreenstein),
    Rayleigh(Rayleigh),
}

macro_rules! phases {
    ($($module:ident),* $(,)?) => {
        /// Every phase function.
        pub static PHASES: &[Entry<AnyPhase>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: $module::parse,
        }),*];
    };
}
phases!(isotropic, hg, rayleigh);

impl AnyPhase {
    /// The density in sr⁻¹ of turning light by an angle of this cosine.
    #[inline]
    pub fn density(&self, cos: f64) -> f64 {
        match self {
            Self::Isotropic(phase) => phase.density(),
            Self::HenyeyGreenstein(phase) => phase.density(cos),
            Self::Rayleigh(phase) => phase.density(cos),
        }
    }

    /// The cosine that a number in [0, 1) stands for: the inverse of the cumulative distribution.
    #[inline]
    fn sample_cosine(&self, u: f64) -> f64 {
        let cos = match self {
            Self::Isotropic(phase) => phase.sample_cosine(u),
            Self::HenyeyGreenstein(phase) => phase.sample_cosine(u),
            Self::Rayleigh(phase) => phase.sample_cosine(u),
        };
        cos.clamp(-1.0, 1.0)
    }

    pub fn name(&self) -> &'static str {
        match self {
            Self::Isotropic(_) => isotropic::NAME,
            Self::HenyeyGreenstein(_) => hg::NAME,
            Self::Rayleigh(_) => rayleigh::NAME,
        }
    }
}

impl Bsdf for AnyPhase {
    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        let pdf = self.density(-wo.dot(wi));
        Evaluation { value: Spectrum::splat(pdf as f32), pdf }
    }

    #[inline]
    fn sample(&self, _wo: DVec3, _lobe: f64, u: DVec2) -> Option<Sample> {
        let cos = self.sample_cosine(u.x);
        let r = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let (sin_around, cos_around) = sin_cos_turn(u.y);
        // ωo is the third axis, and light that is not turned comes from the other side.
        let wi = DVec3::new(r * cos_around, r * sin_around, -cos);
        Some(Sample::with_density(wi, Spectrum::ONE, self.density(cos)))
    }
}
