//! Values at evenly spaced wavelengths.

use super::irregular::number_list;
use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::spectrum::table::Tabulated;

pub const NAME: &str = "regular";
pub const ABOUT: &str = "Values at evenly spaced wavelengths, straight lines between them, nothing outside.";
pub const EXAMPLES: &[&str] = &[r#"<spectrum type="regular"><float name="wavelength_min" value="400"/>
    <float name="wavelength_max" value="700"/><string name="values" value="0.1, 0.4, 0.2"/></spectrum>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let min =
        params.float_where("wavelength_min", 360.0, "first wavelength in nm", "a wavelength", |v| v > 0.0)?;
    let max =
        params.float_where("wavelength_max", 830.0, "last wavelength in nm", "a wavelength", |v| v > min)?;
    if max <= min {
        let expected = "add a `wavelength_max` beyond it";
        return Err(params.error("wavelength_min", "`wavelength_min` is beyond `wavelength_max`", expected));
    }
    let (values, place) = number_list(params, "values", "the values")?;
    let table =
        Tabulated::regular(min as f32, max as f32, values).map_err(|e| params.error("values", e, ""))?;
    color::from_table(table, place, params.usage, params.loader).map(AnyTexture::Constant)
}
