//! Phase functions: how a medium scatters light, as densities over the sphere.
//!
//! *How to add one*: write `phase/<name>.rs` with a type that implements [`Phase`], and add it to the list below.
//! The contract tests follow from the registry.

#[cfg(test)]
mod contract;

use crate::bsdf::{Bsdf, Evaluation, Sample};
use crate::math::function::sin_cos_turn;
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::registry::Entry;
use crate::spectrum::Spectrum;
pub use isotropic::Isotropic;

/// A phase function that depends on nothing but the place and the angle by which light is turned.
pub trait Phase: Sized {
    const NAME: &'static str;
    /// One sentence for `etalon plugins`.
    const ABOUT: &'static str;
    /// Scene-file snippets that span the parameters.
    const EXAMPLES: &'static [&'static str];

    /// Reads its parameters from a scene file.
    ///
    /// # Errors
    /// If one has no such value, with its place.
    fn parse(params: &mut Params) -> Result<Self, SceneError>;

    /// The density in sr⁻¹ of turning light at `p` (world) by an angle of this cosine.
    fn density(&self, p: DVec3, cos: f64) -> f64;

    /// The cosine that two numbers in [0, 1) stand for at `p` (world): `part` chooses one of what is mixed, and
    /// as `u` rises the cosine falls from 1 to −1, the inverse of ∫ 2πp dcos from the cosine to 1.
    fn sample_cosine(&self, p: DVec3, part: f64, u: f64) -> f64;
}

macro_rules! phases {
    ($($module:ident::$Model:ident),* $(,)?) => {
        $(mod $module;)*

        /// Any phase function.
        #[derive(Clone, Debug)]
        pub enum AnyPhase { $($Model($module::$Model)),* }

        impl AnyPhase {
            /// See [`Phase::density`].
            #[inline]
            pub fn density(&self, p: DVec3, cos: f64) -> f64 {
                match self { $(Self::$Model(phase) => phase.density(p, cos)),* }
            }

            /// See [`Phase::sample_cosine`].
            #[inline]
            fn sample_cosine(&self, p: DVec3, part: f64, u: f64) -> f64 {
                match self { $(Self::$Model(phase) => phase.sample_cosine(p, part, u)),* }.clamp(-1.0, 1.0)
            }

            pub fn name(&self) -> &'static str {
                match self { $(Self::$Model(_) => <$module::$Model as Phase>::NAME),* }
            }
        }

        /// Every phase function.
        pub static PHASES: &[Entry<AnyPhase>] = &[$(Entry {
            name: <$module::$Model as Phase>::NAME,
            about: <$module::$Model as Phase>::ABOUT,
            examples: <$module::$Model as Phase>::EXAMPLES,
            parse: |params| <$module::$Model as Phase>::parse(params).map(AnyPhase::$Model),
        }),*];
    };
}

phases! {
    isotropic::Isotropic,
    hg::HenyeyGreenstein,
    rayleigh::Rayleigh,
    tabphase::Tabulated,
    blendphase::Blend,
}

impl AnyPhase {
    /// The phase function at a place in the world.
    #[inline]
    pub fn at(&self, p: DVec3) -> PhaseAt<'_> {
        PhaseAt { phase: self, p }
    }
}

/// A phase function at a place in the world.
///
/// As a [`Bsdf`] it works in any frame whose third axis is ωo, the direction to where the light goes, and has no
/// cosine: `value` is p(cos θ) in sr⁻¹, θ being the angle by which light is turned, so that 0 is straight on.
#[derive(Clone, Copy, Debug)]
pub struct PhaseAt<'a> {
    phase: &'a AnyPhase,
    p: DVec3,
}

/// The cosine of the angle between where light comes from, −ωi, and where it goes: from |ωo ± ωi|² = 2 ∓ 2 cos, whichever
/// is the smaller, so that it is not beyond ±1 by rounding, and exact there.
#[inline]
fn cos_turned(wo: DVec3, wi: DVec3) -> f64 {
    let (sum, difference) = ((wo + wi).length_squared(), (wo - wi).length_squared());
    if sum < difference { 1.0 - 0.5 * sum } else { 0.5 * difference - 1.0 }
}

impl Bsdf for PhaseAt<'_> {
    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        let pdf = self.phase.density(self.p, cos_turned(wo, wi));
        Evaluation { value: Spectrum::splat(pdf as f32), pdf }
    }

    #[inline]
    fn sample(&self, _wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        let cos = self.phase.sample_cosine(self.p, lobe, u.x);
        let r = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let (sin_around, cos_around) = sin_cos_turn(u.y);
        // ωo is the third axis, and light that is not turned comes from the other side.
        let wi = DVec3::new(r * cos_around, r * sin_around, -cos);
        Some(Sample::with_density(wi, Spectrum::ONE, self.phase.density(self.p, cos)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A narrow lobe is asked straight on and straight back along directions whose squared length is not quite one.
    #[test]
    fn light_that_is_not_turned_has_the_density_of_its_peak() {
        for x in [0.0, 1.0, 0.3, -2.7, 1e-4] {
            for y in [1.0, -0.2, 3.1] {
                let wo = DVec3::new(x, y, 0.7).normalize_or_zero();
                assert_eq!(cos_turned(wo, -wo), 1.0);
                assert_eq!(cos_turned(wo, wo), -1.0);
                let across = wo.any_orthonormal_vector();
                assert!(cos_turned(wo, across).abs() < 1e-15);
                let wi = (across - 3.0 * wo).normalize_or_zero();
                assert!((cos_turned(wo, wi) - 3.0 / 10f64.sqrt()).abs() < 1e-15);
            }
        }
    }
}
