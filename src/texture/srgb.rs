//! A colour given as linear sRGB.

use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "srgb";
pub const ABOUT: &str = "A linear sRGB colour; in spectral mode the smooth reflectance that looks like it.";
pub const EXAMPLES: &[&str] =
    &[r#"<spectrum type="srgb"><rgb name="color" value="0.8, 0.3, 0.1"/></spectrum>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let about = "linear sRGB components";
    let found = params.raw("color", "rgb", "none", about)?;
    let element =
        found.ok_or_else(|| params.error("color", "`color` is missing", "add <rgb name=\"color\" …/>"))?;
    color::parse(element, params.loader, params.usage).map(AnyTexture::Constant)
}
