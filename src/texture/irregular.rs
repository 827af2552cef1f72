//! Values at given wavelengths.

use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::transform::numbers;
use crate::scene::xml::Attribute;
use crate::spectrum::table::Tabulated;

pub const NAME: &str = "irregular";
pub const ABOUT: &str = "Values at given wavelengths, straight lines between them, nothing outside.";
pub const EXAMPLES: &[&str] =
    &[r#"<spectrum type="irregular"><string name="wavelengths" value="400, 500, 700"/>
    <string name="values" value="0.1, 0.2, 0.6"/></spectrum>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let (wavelengths, _) = number_list(params, "wavelengths", "increasing wavelengths in nm")?;
    let (values, place) = number_list(params, "values", "the value at each")?;
    let table = Tabulated::new(wavelengths, values).map_err(|e| params.error("wavelengths", e, ""))?;
    color::from_table(table, place, params.usage, params.loader).map(AnyTexture::Constant)
}

/// A required list of numbers.
pub fn number_list<'d>(
    params: &mut Params<'_, 'd>,
    name: &'static str,
    about: &'static str,
) -> Result<(Vec<f32>, &'d Attribute), SceneError> {
    let list = params.string(name, about)?;
    let list =
        list.ok_or_else(|| params.error(name, format!("`{name}` is missing"), "add a list of numbers"))?;
    Ok((numbers(list)?.into_iter().map(|v| v as f32).collect(), list))
}
