//! Light is scattered alike in all directions.

use super::Phase;
use crate::math::{DVec3, INV_PI};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

/// Scattering into all directions alike.
#[derive(Clone, Copy, Debug)]
pub struct Isotropic;

impl Phase for Isotropic {
    const NAME: &'static str = "isotropic";
    const ABOUT: &'static str = "Light is scattered alike in all directions.";
    const EXAMPLES: &'static [&'static str] = &[r#"<phase type="isotropic"/>"#];

    fn parse(_params: &mut Params) -> Result<Self, SceneError> {
        Ok(Self)
    }

    #[inline]
    fn density(&self, _p: DVec3, _cos: f64) -> f64 {
        0.25 * INV_PI
    }

    #[inline]
    fn sample_cosine(&self, _p: DVec3, _part: f64, u: f64) -> f64 {
        1.0 - 2.0 * u
    }
}
