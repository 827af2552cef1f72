//! Light is scattered alike in all directions.

use super::AnyPhase;
use crate::math::INV_PI;
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "isotropic";
pub const ABOUT: &str = "Light is scattered alike in all directions.";
pub const EXAMPLES: &[&str] = &[r#"<phase type="isotropic"/>"#];

/// Scattering into all directions alike.
#[derive(Clone, Copy, Debug)]
pub struct Isotropic;

pub fn parse(_params: &mut Params) -> Result<AnyPhase, SceneError> {
    Ok(AnyPhase::Isotropic(Isotropic))
}

impl Isotropic {
    /// The density in sr⁻¹ of any direction.
    #[inline]
    pub fn density(self) -> f64 {
        0.25 * INV_PI
    }

    /// The cosine of the angle by which light is turned, from a number in [0, 1).
    #[inline]
    pub fn sample_cosine(self, u: f64) -> f64 {
        1.0 - 2.0 * u
    }
}
