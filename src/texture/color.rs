//! `<rgb>`, `<spectrum>` and `<float>`: constants as scene files write them, turned into spectra as Mitsuba
//! turns them. The same numbers mean different spectra for what reflects and for what emits.

use crate::image::srgb::decode;
use crate::scene::error::{SceneError, Span};
use crate::scene::loader::Loader;
use crate::scene::params::{EXPECTED_AMOUNT, MOST, Usage, number};
use crate::scene::spectrum::{self, Declared};
use crate::scene::transform::numbers;
use crate::scene::xml::{Attribute, Element};
use crate::spectrum::table::Tabulated;
use crate::spectrum::{ColorMode, SpectralFunction, observer, upsample::Sigmoid};
use crate::spelling::shortened;
use std::sync::Arc;

pub fn parse<'d>(
    element: &'d Element,
    loader: &Loader<'d>,
    usage: Usage,
) -> Result<SpectralFunction, SceneError> {
    match element.tag.as_str() {
        "float" | "integer" => {
            let number = number_of(element)?;
            check_range(&[number], &element.require("value")?.value_span, usage)?;
            Ok(match usage {
                Usage::Emission => from_rgb([number; 3], usage, loader),
                _ => SpectralFunction::Uniform(number as f32),
            })
        }
        "rgb" | "srgb" => {
            let (rgb, value) = components(element)?;
            check_range(&rgb, &value.value_span, usage)?;
            Ok(from_rgb(rgb, usage, loader))
        }
        "spectrum" => parse_spectrum(element, loader, usage),
        "blackbody" => super::blackbody::parse_legacy(element, loader, usage),
        _ => {
            let message = match element.name() {
                Some(name) => format!("`{name}` cannot be a <{}>", element.tag),
                None => format!("<{}> is no colour", element.tag),
            };
            Err(SceneError::at(&element.span, message, "expected <rgb>, <spectrum>, <float> or <texture>"))
        }
    }
}

/// The number of a `<float>`.
pub fn number_of(element: &Element) -> Result<f64, SceneError> {
    element.only(&["name", "value"])?;
    let value = element.require("value")?;
    let message = || format!("`{}` is no number", value.value);
    number(&value.value).ok_or_else(|| SceneError::at(&value.value_span, message(), "expected a number"))
}

/// The linear numbers of an `<rgb>` or `<srgb>`, and the attribute that holds them.
pub fn components(element: &Element) -> Result<([f64; 3], &Attribute), SceneError> {
    if !["rgb", "srgb"].contains(&element.tag.as_str()) {
        let message = format!("<{}> is no list of components", element.tag);
        return Err(SceneError::at(&element.span, message, "expected <rgb>"));
    }
    element.only(&["name", "value"])?;
    let value = element.require("value")?;
    let rgb = parse_rgb(value, element.tag == "srgb")?;
    Ok((rgb, value))
}

/// One number, three numbers, or `#rrggbb`, which is always encoded; other numbers are only where `encoded`.
fn parse_rgb(value: &Attribute, encoded: bool) -> Result<[f64; 3], SceneError> {
    if let Some(digits) = value.value.trim().strip_prefix('#') {
        let six = digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        let parsed = u32::from_str_radix(digits, 16).ok().filter(|_| six);
        let code = parsed.ok_or_else(|| {
            SceneError::at(&value.value_span, format!("`{}` is no colour", value.value), "expected #rrggbb")
        })?;
        return Ok([16, 8, 0].map(|shift| decode((code >> shift & 255) as f64 / 255.0)));
    }
    let linear = |v| if encoded { decode(v) } else { v };
    match numbers(value)?[..] {
        [v] => Ok([linear(v); 3]),
        [r, g, b] => Ok([r, g, b].map(linear)),
        ref n => Err(SceneError::at(
            &value.value_span,
            format!("`{}` is {} numbers", shortened(&value.value), n.len()),
            "expected one or three numbers",
        )),
    }
}

/// Refuses reflectances beyond 0 to 1, and of anything else what is negative or more than f32 can hold.
pub fn check_range(values: &[f64], place: &Span, usage: Usage) -> Result<(), SceneError> {
    let (top, expected) = match usage {
        Usage::Reflectance | Usage::Vector => (1.0, "expected 0 to 1"),
        Usage::Emission | Usage::Unbounded | Usage::Any => (MOST, EXPECTED_AMOUNT),
    };
    // Numbers are kept as `f32`, as in Mitsuba: what rounds to 1 is 1.
    match values.iter().find(|v| !(**v >= 0.0 && **v as f32 <= top as f32)) {
        None => Ok(()),
        Some(v) => {
            let number = if (1e-6..1e12).contains(&v.abs()) { v.to_string() } else { format!("{v:e}") };
            Err(SceneError::at(place, format!("{number} is out of range"), expected))
        }
    }
}

/// The spectrum of a linear sRGB colour, or three numbers where no colour is meant.
pub fn from_rgb(rgb: [f64; 3], usage: Usage, loader: &Loader) -> SpectralFunction {
    if usage.is_numbers(loader.mode) {
        return SpectralFunction::Rgb(rgb.map(|v| v as f32));
    }
    match usage {
        Usage::Reflectance => SpectralFunction::Sigmoid(loader.upsampler.fit(rgb.map(|v| v as f32))),
        Usage::Unbounded if rgb[0] == rgb[1] && rgb[1] == rgb[2] => SpectralFunction::Uniform(rgb[0] as f32),
        Usage::Unbounded => {
            let (scale, color) = loader.upsampler.fit_in_proportion(rgb);
            SpectralFunction::Scaled { scale, color }
        }
        Usage::Emission | Usage::Vector | Usage::Any => {
            let (scale, color) = scaled(rgb);
            if scale == 0.0 {
                return SpectralFunction::Uniform(0.0);
            }
            let color = loader.upsampler.fit(color);
            SpectralFunction::Illuminant { scale, color }
        }
    }
}

/// An emission as twice its largest component times a colour whose largest is ½, where spectra are smoothest.
pub fn scaled(rgb: [f64; 3]) -> (f32, [f32; 3]) {
    let scale = 2.0 * rgb.iter().fold(0.0f64, |m, v| m.max(*v));
    (scale as f32, rgb.map(|v| if scale > 0.0 { (v / scale) as f32 } else { 0.0 }))
}

/// D65 with this luminance.
pub fn white_illuminant(value: f64) -> SpectralFunction {
    SpectralFunction::Illuminant { scale: (2.0 * value) as f32, color: Sigmoid([0.0, 0.0, 0.0]) }
}

fn parse_spectrum<'d>(
    element: &'d Element,
    loader: &Loader<'d>,
    usage: Usage,
) -> Result<SpectralFunction, SceneError> {
    match spectrum::parse(element, loader)? {
        (Declared::Number(value), place) => {
            check_range(&[value], &place.value_span, usage)?;
            Ok(uniform(value, usage, loader.mode))
        }
        (Declared::Table(table), place) => from_table(table, place, usage, loader),
    }
}

/// Equal energy at all wavelengths.
pub fn uniform(value: f64, usage: Usage, mode: ColorMode) -> SpectralFunction {
    if mode == ColorMode::Rgb && usage == Usage::Emission {
        // Equal energy is not the white of sRGB.
        return SpectralFunction::Rgb(observer::xyz_to_rgb([value; 3]).map(|v| v as f32));
    }
    SpectralFunction::Uniform(value as f32)
}

/// A measured spectrum: as it is, or as the colour that RGB mode makes of it.
pub fn from_table(
    table: Tabulated,
    place: &Attribute,
    usage: Usage,
    loader: &Loader,
) -> Result<SpectralFunction, SceneError> {
    let (low, high) = table.bounds();
    let (top, expected) = match usage {
        Usage::Reflectance => (1.0, "expected values from 0 to 1"),
        _ => (MOST as f32, EXPECTED_AMOUNT),
    };
    if low < 0.0 || high > top {
        let bad = if low < 0.0 { low } else { high };
        return Err(SceneError::at(
            &place.value_span,
            format!("the spectrum has a value of {bad}"),
            expected,
        ));
    }
    if loader.mode == ColorMode::Spectral {
        return Ok(SpectralFunction::Table(Arc::new(table)));
    }
    let emitted = usage == Usage::Emission;
    let rgb = if emitted { observer::emission_to_rgb(&table) } else { observer::reflectance_to_rgb(&table) };
    Ok(SpectralFunction::Rgb(rgb.map(|v| v.clamp(0.0, top as f64) as f32)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::xml;

    /// What RGB mode makes of a colour that reflects or emits.
    fn color(written: &str, usage: Usage) -> [f32; 3] {
        let text = format!(r#"<scene version="3.0.0">{written}</scene>"#);
        let document = xml::read_text("t", &text).unwrap();
        let loader = Loader::new(&document, ColorMode::Rgb).unwrap();
        match parse(&document.root.children[0], &loader, usage).unwrap() {
            SpectralFunction::Rgb(rgb) => rgb,
            SpectralFunction::Uniform(value) => [value; 3],
            _ => panic!("{written} has no colour"),
        }
    }

    #[test]
    fn hexadecimal_colours_and_srgb_are_encoded() {
        // IEC 61966-2-1: ((c + 0.055)/1.055)^2.4, and c/12.92 below 0.04045.
        let written = [
            r##"<rgb name="c" value="#80ff05"/>"##,
            r##"<srgb name="c" value="#80ff05"/>"##,
            r#"<srgb name="c" value="0.501960784, 1, 0.019607843"/>"#,
        ];
        let expected = [((128.0 / 255.0 + 0.055f64) / 1.055).powf(2.4), 1.0, 5.0 / 255.0 / 12.92];
        for text in written {
            for (got, expected) in color(text, Usage::Reflectance).into_iter().zip(expected) {
                assert!((f64::from(got) - expected).abs() < 1e-7, "{text}: {got} {expected}");
            }
        }
        assert_eq!(color(r#"<rgb name="c" value="0.5"/>"#, Usage::Reflectance), [0.5; 3]);
    }

    #[test]
    fn what_reflects_everything_is_white_and_light_of_equal_energy_is_not() {
        let flat = r#"<spectrum name="c" value="360:1, 830:1"/>"#;
        // The two colours that Mitsuba gives equal energy, under D65 and alone.
        let cases = [(Usage::Reflectance, [1.0; 3]), (Usage::Emission, [1.206, 0.949, 0.910])];
        for (usage, expected) in cases {
            for (got, expected) in color(flat, usage).into_iter().zip(expected) {
                // The range of the sum, which counts 1000/999 times, is clamped for what reflects.
                assert!((got - expected).abs() < 2e-3, "{usage:?} {got} {expected}");
            }
        }
    }
}
