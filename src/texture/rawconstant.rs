//! Numbers as they are.

use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::scene::transform::coordinates;
use crate::spectrum::{ColorMode, SpectralFunction};

pub const NAME: &str = "rawconstant";
pub const ABOUT: &str = "One number, or three, everywhere: no colour, so nothing is converted.";
pub const EXAMPLES: &[&str] = &[r#"<texture type="rawconstant"><float name="value" value="0.4"/></texture>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let about = "a <float>, or a <vector> for normals or, in rgb, for a colour";
    let element = params.raw("value", "float", "none", about)?;
    let element = element.ok_or_else(|| params.error("value", "`value` is missing", "add a <float>"))?;
    if element.tag == "float" {
        let number = color::number_of(element)?;
        color::check_range(&[number], &element.span, params.usage)?;
        return Ok(AnyTexture::Constant(SpectralFunction::Uniform(number as f32)));
    }
    if element.tag != "vector" && element.tag != "point" {
        let message = format!("<{}> is no raw value", element.tag);
        return Err(SceneError::at(&element.span, message, "expected <float> or <vector>"));
    }
    let three = coordinates(element, &["name"], 0.0)?.to_array();
    color::check_range(&three, &element.span, params.usage)?;
    if params.usage != Usage::Vector && params.loader.mode == ColorMode::Spectral {
        return Err(SceneError::at(&element.span, "three numbers are no spectrum", "expected <float>"));
    }
    Ok(AnyTexture::Constant(SpectralFunction::Rgb(three.map(|v| v as f32))))
}

#[cfg(test)]
mod tests {
    use crate::math::{DVec2, DVec3};
    use crate::scene::loader::Loader;
    use crate::scene::params::Usage;
    use crate::scene::xml;
    use crate::spectrum::{ColorMode, Wavelengths};
    use crate::texture::AnyTexture;

    fn texture(value: &str, mode: ColorMode, usage: Usage) -> Result<AnyTexture, String> {
        let text = format!(
            r#"<scene version="3.0.0"><texture type="rawconstant" name="normalmap">{value}</texture></scene>"#
        );
        let document = xml::read_text("raw.xml", &text).unwrap();
        let loader = Loader::new(&document, mode).unwrap();
        AnyTexture::parse(&document.root.children[0], &loader, usage).map_err(|e| e.to_string())
    }

    #[test]
    fn numbers_stay_as_they_are() {
        let vector = r#"<vector name="value" value="0.5, 0.25, 1"/>"#;
        for mode in [ColorMode::Rgb, ColorMode::Spectral] {
            let normal = texture(vector, mode, Usage::Vector).unwrap();
            assert_eq!(normal.eval_vector(DVec2::ZERO), Some(DVec3::new(0.5, 0.25, 1.0)));
            let light = texture(r#"<float name="value" value="3"/>"#, mode, Usage::Emission).unwrap();
            assert_eq!(light.constant(), Some(3.0));
        }
        let color = texture(vector, ColorMode::Rgb, Usage::Reflectance).unwrap();
        assert_eq!(color.eval(DVec2::ZERO, &Wavelengths::rgb()).0[..3], [0.5, 0.25, 1.0]);
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for (value, usage, says) in [
            (r#"<vector name="value" value="0.5, 0.25, 1"/>"#, Usage::Reflectance, "no spectrum"),
            (r#"<float name="value" value="1.5"/>"#, Usage::Reflectance, "1.5 is out of range"),
            (r#"<float name="value" value="half"/>"#, Usage::Any, "`half` is no number"),
            (r#"<rgb name="value" value="0.5"/>"#, Usage::Any, "no raw value"),
            ("", Usage::Any, "missing"),
        ] {
            let error = texture(value, ColorMode::Spectral, usage).unwrap_err();
            assert!(error.contains(says) && error.contains("raw.xml"), "{value}: {error}");
        }
    }
}
