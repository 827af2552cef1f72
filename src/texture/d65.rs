//! Daylight, alone or colouring another texture.

use super::{AnyTexture, color};
use crate::math::DVec2;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::spectrum::{ColorMode, SpectralFunction, Spectrum, Wavelengths};

pub const NAME: &str = "d65";
pub const ABOUT: &str = "The CIE illuminant D65 at luminance 1, times a scale and a colour or texture.";
pub const EXAMPLES: &[&str] = &[
    r#"<spectrum type="d65"><float name="scale" value="2"/></spectrum>"#,
    r#"<spectrum type="d65"><rgb name="color" value="1, 0.5, 0.2"/></spectrum>"#,
];

/// `scale` × a texture × D65.
#[derive(Clone, Debug)]
pub struct UnderD65 {
    texture: AnyTexture,
    scale: f32,
}

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let scale = params.amount("scale", 1.0, "factor")?;
    if let Some(element) = params.raw("color", "rgb", "1", "linear sRGB colour of the light")? {
        if !["rgb", "srgb"].contains(&element.tag.as_str()) {
            let message = format!("`color` cannot be a <{}>", element.tag);
            return Err(SceneError::at(&element.span, message, "expected <rgb>"));
        }
        element.only(&["name", "value"])?;
        let value = element.require("value")?;
        let rgb = color::parse_rgb(value)?.map(|v| v * scale);
        color::check_range(&rgb, value, Usage::Emission)?;
        return Ok(AnyTexture::Constant(color::from_rgb(rgb, Usage::Emission, params.loader)));
    }
    if let Some(element) = params.object("texture", "a texture to multiply")? {
        let texture = AnyTexture::parse(element, params.loader, Usage::Reflectance)?;
        return Ok(AnyTexture::UnderD65(Box::new(UnderD65 { texture, scale: scale as f32 })));
    }
    Ok(AnyTexture::default_value(scale, Usage::Emission, params.loader.mode))
}

impl UnderD65 {
    pub fn eval(&self, uv: DVec2, λ: &Wavelengths) -> Spectrum {
        let value = self.texture.eval(uv, λ) * self.scale;
        match λ.mode() {
            ColorMode::Rgb => value,
            ColorMode::Spectral => value * Spectrum(λ.d65),
        }
    }

    pub fn eval_scalar(&self, uv: DVec2) -> f64 {
        self.texture.eval_scalar(uv) * self.scale as f64
    }

    pub fn mean(&self) -> f64 {
        self.texture.mean() * self.scale as f64 * SpectralFunction::mean(&color::white_illuminant(1.0))
    }

    /// Of a texture of reflectances that reaches 1.
    pub fn peak(&self) -> f32 {
        color::white_illuminant(1.0).peak() * self.scale
    }

    pub fn varies(&self) -> bool {
        self.texture.varies()
    }
}
