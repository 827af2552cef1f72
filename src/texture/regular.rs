//! Values at evenly spaced wavelengths.

use super::irregular::number_list;
use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::spectrum::observer::{WAVELENGTH_MAX, WAVELENGTH_MIN};
use crate::spectrum::table::Tabulated;

pub const NAME: &str = "regular";
pub const ABOUT: &str = "Values at evenly spaced wavelengths, straight lines between them, nothing outside.";
pub const EXAMPLES: &[&str] = &[r#"<spectrum type="regular"><float name="wavelength_min" value="400"/>
    <float name="wavelength_max" value="700"/><string name="values" value="0.1, 0.4, 0.2"/></spectrum>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let (min, max) = wavelength_range(params)?;
    let (values, place) = number_list(params, "values", "the values")?;
    let table = Tabulated::regular(min, max, values).map_err(|e| params.error("values", e, ""))?;
    color::from_table(table, place, params.usage, params.loader).map(AnyTexture::Constant)
}

/// `wavelength_min` and `wavelength_max`, by default those of the visible range.
pub fn wavelength_range(params: &mut Params) -> Result<(f32, f32), SceneError> {
    let (first, last) = (f64::from(WAVELENGTH_MIN), f64::from(WAVELENGTH_MAX));
    let about = "first wavelength in nm";
    let min = params.float_where("wavelength_min", first, about, "a wavelength", |v| v > 0.0)?;
    let about = "last wavelength in nm";
    let max =
        params.float_where("wavelength_max", last, about, "a wavelength beyond `wavelength_min`", |v| {
            v > min
        })?;
    if max <= min {
        let expected = "add a `wavelength_max` beyond it";
        return Err(params.error("wavelength_min", "`wavelength_min` is beyond `wavelength_max`", expected));
    }
    Ok((min as f32, max as f32))
}
