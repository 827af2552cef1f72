//! A colour given as linear sRGB.

use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};

pub const NAME: &str = "srgb";
pub const ABOUT: &str = "A linear sRGB colour; in spectral mode the smooth reflectance that looks like it.";
pub const EXAMPLES: &[&str] =
    &[r#"<spectrum type="srgb"><rgb name="color" value="0.8, 0.3, 0.1"/></spectrum>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let about = "linear sRGB components";
    let found = params.raw("color", "rgb", "none", about)?;
    let element =
        found.ok_or_else(|| params.error("color", "`color` is missing", "add <rgb name=\"color\" …/>"))?;
    let about = "whether components may exceed 1 where it shines; in spectral mode they count as 1";
    let unbounded = params.boolean("unbounded", false, about)?;
    if unbounded && params.usage == Usage::Emission {
        let (rgb, value) = color::components(element)?;
        color::check_range(&rgb, &value.value_span, Usage::Emission)?;
        return Ok(AnyTexture::Constant(color::from_rgb(rgb, Usage::Reflectance, params.loader)));
    }
    // As in Mitsuba it stays a reflectance even as an emission: there <rgb> is relative to D65, this is not.
    let usage = if params.usage == Usage::Emission { Usage::Reflectance } else { params.usage };
    color::parse(element, params.loader, usage).map(AnyTexture::Constant)
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::math::DVec3;
    use crate::scene::error::SceneError;
    use crate::spectrum::{ColorMode, Wavelengths};

    /// What surrounds a scene with this radiance, or the error.
    fn radiance(spectrum: &str, mode: ColorMode) -> Result<[f32; 8], SceneError> {
        let text = format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\">{spectrum}</emitter></scene>"
        );
        let scene = load_text("scene.xml", &text, mode)?;
        let λ = if mode == ColorMode::Rgb { Wavelengths::rgb() } else { Wavelengths::sample_visible(0.03) };
        let emitter = &scene.emitters.list[0].emitter;
        let found = emitter.distant_radiance(&emitter.view(DVec3::Z), &λ);
        Ok(found.unwrap().0)
    }

    #[test]
    fn a_lamp_of_white_srgb_has_the_same_radiance_at_all_wavelengths() {
        let white = "name=\"color\" value=\"1, 1, 1\"/>";
        let of = |spectrum: &str| radiance(spectrum, ColorMode::Spectral).unwrap();
        let flat = of(&format!("<spectrum type=\"srgb\" name=\"radiance\"><rgb {white}</spectrum>"));
        let d65 = of(&format!("<rgb {}", white.replace("color", "radiance")));
        assert!(flat.iter().all(|v| (v - 1.0).abs() < 1e-3), "{flat:?}");
        assert!(d65.iter().any(|v| (v - 1.0).abs() > 0.05), "{d65:?}");
    }

    #[test]
    fn what_shines_may_exceed_1_if_it_says_so() {
        let lamp = |unbounded: bool| {
            format!(
                r#"<spectrum type="srgb" name="radiance"><rgb name="color" value="2, 2, 2"/>
                <boolean name="unbounded" value="{unbounded}"/></spectrum>"#
            )
        };
        assert_eq!(radiance(&lamp(true), ColorMode::Rgb).unwrap()[..3], [2.0; 3]);
        // The table of spectra ends at 1, in Mitsuba as here.
        let spectral = radiance(&lamp(true), ColorMode::Spectral).unwrap();
        assert!(spectral.iter().all(|v| (v - 1.0).abs() < 1e-3), "{spectral:?}");
        assert!(radiance(&lamp(false), ColorMode::Rgb).unwrap_err().expected.contains("0 to 1"));
    }
}
