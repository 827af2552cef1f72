//! The illuminant D65, alone or times another texture.

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
    r#"<spectrum type="d65"><float name="scale" value="3"/><texture type="checkerboard" name="texture">
        <rgb name="color0" value="0.9, 0.2, 0.1"/><rgb name="color1" value="0.3"/></texture></spectrum>"#,
];

/// `scale` × a texture × D65.
#[derive(Clone, Debug)]
pub struct UnderD65 {
    texture: AnyTexture,
    scale: f32,
    mode: ColorMode,
}

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let scale = params.amount("scale", 1.0, "factor")?;
    if let Some(element) = params.raw("color", "rgb", "1", "linear sRGB colour of the light")? {
        let (rgb, value) = color::components(element)?;
        let rgb = rgb.map(|v| v * scale);
        color::check_range(&rgb, &value.value_span, Usage::Emission)?;
        return Ok(AnyTexture::Constant(color::from_rgb(rgb, Usage::Emission, params.loader)));
    }
    let about = "a texture or spectrum to multiply";
    if let Some((element, _)) = params.one_nested("texture", about, AnyTexture::is_object)? {
        // Pictures of light may be brighter than white.
        let light = params.usage != Usage::Reflectance;
        let usage = if light { Usage::Unbounded } else { Usage::Reflectance };
        let texture = AnyTexture::parse(element, params.loader, usage)?;
        let product = UnderD65 { texture, scale: scale as f32, mode: params.loader.mode };
        return Ok(AnyTexture::UnderD65(Box::new(product)));
    }
    Ok(AnyTexture::default_value(scale, Usage::Emission, params.loader.mode))
}

impl UnderD65 {
    /// See [`AnyTexture::aspect`].
    pub fn aspect(&self) -> f64 {
        self.texture.aspect()
    }

    /// The value in each lane at texture coordinates `uv`.
    pub fn eval(&self, uv: DVec2, λ: &Wavelengths) -> Spectrum {
        let value = self.texture.eval(uv, λ) * self.scale;
        match λ.mode() {
            ColorMode::Rgb => value,
            ColorMode::Spectral => value * Spectrum(λ.d65),
        }
    }

    /// The value at texture coordinates `uv` where one number is asked for.
    pub fn eval_scalar(&self, uv: DVec2) -> f64 {
        self.texture.eval_scalar(uv) * self.scale as f64
    }

    /// See [`AnyTexture::luminance`].
    pub fn luminance(&self, uv: DVec2) -> f64 {
        self.texture.luminance(uv) * self.scale as f64
    }

    /// The mean over the texture and the spectrum.
    pub fn mean(&self) -> f64 {
        self.texture.mean() * self.scale as f64 * self.white().mean()
    }

    /// White under D65: what the texture is multiplied by.
    fn white(&self) -> SpectralFunction {
        match self.mode {
            ColorMode::Rgb => SpectralFunction::Uniform(1.0),
            ColorMode::Spectral => color::white_illuminant(1.0),
        }
    }

    /// See [`AnyTexture::bound`].
    pub fn bound(&self) -> f32 {
        self.texture.bound() * self.white().bound() * self.scale
    }

    pub fn varies(&self) -> bool {
        self.texture.varies()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::loader::Loader;
    use crate::scene::xml;

    /// At one place, of what is written within `d65`.
    fn light(within: &str) -> Result<Spectrum, SceneError> {
        let text = format!(r#"<scene version="3.0.0"><spectrum type="d65">{within}</spectrum></scene>"#);
        let document = xml::read_text("t", &text)?;
        let loader = Loader::new(&document, ColorMode::Spectral)?;
        let texture = AnyTexture::parse(&document.root.children[0], &loader, Usage::Emission)?;
        Ok(texture.eval(DVec2::ZERO, &Wavelengths::sample_visible(0.3)))
    }

    #[test]
    fn a_nested_spectrum_is_a_factor_as_a_texture_is() {
        let white = light("").unwrap();
        for tag in ["spectrum", "texture"] {
            let half = format!(r#"<{tag} type="uniform" name="n"><float name="value" value="0.5"/></{tag}>"#);
            let dimmed = light(&half).unwrap();
            let apart = dimmed.zip(white, |a, b| a - 0.5 * b);
            assert!(apart.0.iter().all(|v| v.abs() < 1e-6), "{tag} {dimmed:?} {white:?}");
        }
        // A value that is no object has no name that is known here.
        let error = light(r#"<spectrum name="n" value="0.5"/>"#).unwrap_err();
        assert!(error.message.contains("no parameter `n`"), "{error}");
    }

    #[test]
    fn a_reflectance_is_refused_by_its_own_largest_value() {
        let parsed = |within: &str, mode: ColorMode| {
            let text = format!(r#"<scene version="3.0.0"><spectrum type="d65">{within}</spectrum></scene>"#);
            let document = xml::read_text("t", &text).unwrap();
            let loader = Loader::new(&document, mode).unwrap();
            AnyTexture::parse(&document.root.children[0], &loader, Usage::Reflectance)
                .err()
                .map(|e| e.message)
        };
        let half = r#"<spectrum type="uniform" name="n"><float name="value" value="0.5"/></spectrum>"#;
        let scale = |scale: f64| format!(r#"<float name="scale" value="{scale}"/>"#);
        for mode in [ColorMode::Spectral, ColorMode::Rgb] {
            assert_eq!(parsed(&scale(0.5), mode), None);
            assert_eq!(parsed(&(scale(0.8) + half), mode), None);
            let board = r#"<texture type="checkerboard" name="n"><rgb name="color0" value="0.3"/><rgb name="color1" value="0.2"/></texture>"#;
            assert_eq!(parsed(board, mode), None);
        }
        // D65 of luminance 1 has its largest value, 1.19, at 460 nm.
        let error = parsed(&scale(0.9), ColorMode::Spectral).unwrap();
        assert!(error.starts_with("values up to 1.07"), "{error}");
        assert_eq!(parsed(&scale(0.9), ColorMode::Rgb), None);
    }
}
