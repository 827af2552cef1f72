//! Thermal light.

use super::AnyTexture;
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::{Params, number};
use crate::scene::xml::Element;
use crate::spectrum::table::Tabulated;
use crate::spectrum::{ColorMode, SpectralFunction, blackbody, observer};

pub const NAME: &str = "blackbody";
pub const ABOUT: &str = "Planck's law: the radiance of a black body, in W·m⁻²·sr⁻¹·nm⁻¹.";
pub const EXAMPLES: &[&str] = &[
    r#"<spectrum type="blackbody"><float name="temperature" value="5000"/></spectrum>"#,
    r#"<spectrum type="blackbody"><float name="temperature" value="2700"/><float name="scale" value="0.001"/></spectrum>"#,
];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let kelvin =
        params.float_where("temperature", 5000.0, "temperature in K", TEMPERATURE, is_temperature)?;
    let scale = params.float_where("scale", 1.0, "factor (an extension)", FACTOR, is_factor)?;
    Ok(AnyTexture::Constant(resolve(kelvin, scale, params.loader.mode)))
}

/// `<blackbody name= temperature= scale=>`, the element of Mitsuba 0.6.
pub fn parse_legacy<'d>(element: &'d Element, loader: &Loader<'d>) -> Result<SpectralFunction, SceneError> {
    element.only(&["name", "temperature", "scale"])?;
    let temperature = element.require("temperature")?;
    let kelvin = number(temperature.value.trim_end_matches(['k', 'K']))
        .filter(|v| is_temperature(*v))
        .ok_or_else(|| {
            SceneError::at(
                &temperature.value_span,
                format!("`{}` is no temperature", temperature.value),
                format!("expected {TEMPERATURE}"),
            )
        })?;
    let scale = match element.attribute("scale") {
        None => 1.0,
        Some(a) => number(&a.value).filter(|v| is_factor(*v)).ok_or_else(|| {
            SceneError::at(&a.value_span, format!("`{}` is no factor", a.value), format!("expected {FACTOR}"))
        })?,
    };
    Ok(resolve(kelvin, scale, loader.mode))
}

/// Beyond, hc/λkT is lost beside 1.
const TEMPERATURE: &str = "kelvin above 0, up to 1e12";

const FACTOR: &str = "0 to 1e20";

/// The hottest body's radiance times this is within what `f32` holds.
fn is_factor(v: f64) -> bool {
    (0.0..=1e20).contains(&v)
}

fn is_temperature(kelvin: f64) -> bool {
    kelvin > 0.0 && kelvin <= 1e12
}

fn resolve(kelvin: f64, scale: f64, mode: ColorMode) -> SpectralFunction {
    if mode == ColorMode::Spectral {
        return SpectralFunction::Blackbody { kelvin, scale };
    }
    let step = (observer::WAVELENGTH_MAX - observer::WAVELENGTH_MIN) / 188.0;
    let radiance = |i: i32| {
        (scale * blackbody::radiance(kelvin, (observer::WAVELENGTH_MIN + step * i as f32) as f64)) as f32
    };
    let values = (0..=188).map(radiance).collect();
    let table = Tabulated::regular(observer::WAVELENGTH_MIN, observer::WAVELENGTH_MAX, values);
    // Planck's law is finite and positive everywhere, and the range is not empty.
    let rgb = table.map_or([0.0; 3], |t| observer::table_to_rgb(&t, false));
    SpectralFunction::Rgb(rgb.map(|v| v.max(0.0) as f32))
}
