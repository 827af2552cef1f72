//! Mitsuba's second integrator for media, whose distances suit all wavelengths. Those of
//! [`volpath`](super::volpath) do here, so both are one.

use super::AnyIntegrator;
use super::volpath;
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "volpathmis";
pub const ABOUT: &str = "Accepted for Mitsuba's sake; the same as `volpath`.";
pub const EXAMPLES: &[&str] = &[r#"<integrator type="volpathmis"/>"#];

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    params.boolean("use_spectral_mis", true, "Mitsuba's; ignored, for it always is")?;
    volpath::parse(params)
}
