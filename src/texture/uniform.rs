//! The same value at every wavelength.

use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "uniform";
pub const ABOUT: &str = "The same value at every wavelength; as a light, equal-energy white.";
pub const EXAMPLES: &[&str] = &[r#"<spectrum type="uniform"><float name="value" value="0.1"/></spectrum>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let value = params.amount("value", 1.0, "the value")?;
    // In Mitsuba the value holds outside as well.
    for name in ["wavelength_min", "wavelength_max"] {
        params.optional_float(name, "Mitsuba's sampling option; ignored")?;
    }
    Ok(AnyTexture::Constant(color::uniform(value, params.usage, params.loader.mode)))
}
