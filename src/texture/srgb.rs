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
    // As in Mitsuba it stays a reflectance where it shines: there <rgb> is a colour of D65, and this is none.
    let usage = if params.usage == Usage::Emission { Usage::Reflectance } else { params.usage };
    color::parse(element, params.loader, usage).map(AnyTexture::Constant)
}

#[cfg(test)]
mod tests {
    use crate::scene::load_text;
    use crate::spectrum::{ColorMode, Wavelengths};

    #[test]
    fn a_lamp_of_white_srgb_has_the_same_radiance_at_all_wavelengths() {
        let radiance = |spectrum: &str| {
            let text = format!(
                "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\">{spectrum}</emitter></scene>"
            );
            let scene = load_text("scene.xml", &text, ColorMode::Spectral).unwrap();
            let λ = Wavelengths::sample_visible(0.03);
            scene.emitters.list[0]
                .emitter
                .distant_radiance(crate::math::DVec3::Z, crate::math::DVec3::ZERO, &λ)
                .unwrap()
                .0
                .0
        };
        let white = "name=\"color\" value=\"1, 1, 1\"/>";
        let flat = radiance(&format!("<spectrum type=\"srgb\" name=\"radiance\"><rgb {white}</spectrum>"));
        let d65 = radiance(&format!("<rgb {}", white.replace("color", "radiance")));
        assert!(flat.iter().all(|v| (v - 1.0).abs() < 1e-3), "{flat:?}");
        assert!(d65.iter().any(|v| (v - 1.0).abs() > 0.05), "{d65:?}");
    }
}
