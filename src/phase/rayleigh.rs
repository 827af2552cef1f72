//! Rayleigh scattering, by what is much smaller than the wavelength (Chandrasekhar 1960, §1.3):
//!
//! p(cos θ) = 3/(16π) (1 + cos²θ).

use super::Phase;
use crate::math::function::cbrt;
use crate::math::{DVec3, INV_PI};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

/// Scattering by what is far smaller than a wavelength, of light without polarisation.
#[derive(Clone, Copy, Debug)]
pub struct Rayleigh;

impl Phase for Rayleigh {
    const NAME: &'static str = "rayleigh";
    const ABOUT: &'static str = "Scattering by particles much smaller than the wavelength, such as air.";
    const EXAMPLES: &'static [&'static str] = &[r#"<phase type="rayleigh"/>"#];

    fn parse(_params: &mut Params) -> Result<Self, SceneError> {
        Ok(Self)
    }

    #[inline]
    fn density(&self, _p: DVec3, cos: f64) -> f64 {
        3.0 / 16.0 * INV_PI * (1.0 + cos * cos)
    }

    /// The cumulative distribution is (4 − 3 cos θ − cos³θ)/8, so the cosine is the one real root of c³ + 3c
    /// = 4 − 8u = 2z, by Cardano's formula a − 1/a with a³ = z + √(z² + 1).
    #[inline]
    fn sample_cosine(&self, _p: DVec3, _part: f64, u: f64) -> f64 {
        let z = 2.0 - 4.0 * u;
        // By the larger of the two cube roots, which does not cancel; their signs are opposite.
        let root = cbrt(z.abs() + (z * z + 1.0).sqrt());
        (root - 1.0 / root).copysign(z)
    }
}
