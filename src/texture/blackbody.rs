//! Thermal light.

use super::AnyTexture;
use super::regular::wavelength_range;
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::{Params, Usage, number};
use crate::scene::xml::Element;
use crate::spectrum::blackbody::Blackbody;
use crate::spectrum::{ColorMode, SpectralFunction, observer};
use std::sync::Arc;

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
    let range = wavelength_range(params)?;
    Ok(AnyTexture::Constant(resolve(Blackbody { kelvin, scale, range }, params.usage, params.loader.mode)))
}

/// `<blackbody name= temperature= scale=>`, the element of Mitsuba 0.6.
pub fn parse_legacy<'d>(
    element: &'d Element,
    loader: &Loader<'d>,
    usage: Usage,
) -> Result<SpectralFunction, SceneError> {
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
    let range = (observer::WAVELENGTH_MIN, observer::WAVELENGTH_MAX);
    Ok(resolve(Blackbody { kelvin, scale, range }, usage, loader.mode))
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

/// What is no light itself, but a factor of it, has the colour that it has under D65, as a table has.
fn resolve(body: Blackbody, usage: Usage, mode: ColorMode) -> SpectralFunction {
    if mode == ColorMode::Spectral {
        return SpectralFunction::Blackbody(Arc::new(body));
    }
    let light = |λ| if usage == Usage::Emission { 1.0 } else { observer::d65(λ) };
    let rgb = observer::integral_to_rgb(body.range, |λ| f64::from(body.eval(λ) * light(λ)));
    SpectralFunction::Rgb(rgb.map(|v| v.max(0.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec2;
    use crate::scene::xml;
    use crate::spectrum::Wavelengths;
    use crate::spectrum::blackbody::radiance;

    fn parsed(inside: &str, mode: ColorMode) -> AnyTexture {
        let text = format!(
            r#"<scene version="3.0.0"><spectrum type="blackbody"><float name="temperature" value="4000"/>{inside}</spectrum></scene>"#
        );
        let document = xml::read_text("t", &text).unwrap();
        let loader = Loader::new(&document, mode).unwrap();
        AnyTexture::parse(&document.root.children[0], &loader, Usage::Emission).unwrap()
    }

    /// As in Mitsuba, by default there is none beyond the visible range, which the bands of a film may see.
    #[test]
    fn there_is_no_light_outside_of_the_range() {
        let limit = |name: &str, nm: u32| format!(r#"<float name="wavelength_{name}" value="{nm}"/>"#);
        let narrow = limit("min", 500) + &limit("max", 600);
        let narrow = narrow.as_str();
        for (inside, range) in [("", 360.0f32..=830.0), (narrow, 500.0f32..=600.0)] {
            let body = parsed(inside, ColorMode::Spectral);
            for step in 0..10u8 {
                let λ = Wavelengths::sample_uniform(f64::from(step) / 80.0, 300.0, 900.0);
                for (nm, found) in λ.nm.iter().zip(body.eval(DVec2::ZERO, &λ).0) {
                    let law = radiance(4000.0, f64::from(*nm)) as f32;
                    assert_eq!(found, if range.contains(nm) { law } else { 0.0 }, "{nm}");
                }
            }
        }
        let [all, part] = ["", narrow].map(|inside| parsed(inside, ColorMode::Rgb).mean());
        assert!(part > 0.0 && part < 0.8 * all, "{part} {all}");
    }

    /// In RGB mode as in spectral mode: the integral over the range, which may be narrow; as a factor, under D65.
    #[test]
    fn colours_are_integrals_over_the_range() {
        for (first, last) in [(360.0f32, 830.0f32), (600.0, 601.0), (500.5, 502.0)] {
            let text = format!(
                r#"<scene version="3.0.0"><spectrum type="blackbody"><float name="temperature" value="5000"/>
                <float name="scale" value="1e-6"/><float name="wavelength_min" value="{first}"/>
                <float name="wavelength_max" value="{last}"/></spectrum></scene>"#
            );
            let document = xml::read_text("t", &text).unwrap();
            let loader = Loader::new(&document, ColorMode::Rgb).unwrap();
            for (usage, factor) in [(Usage::Emission, false), (Usage::Reflectance, true)] {
                let texture = AnyTexture::parse(&document.root.children[0], &loader, usage).unwrap();
                let found = texture.eval(DVec2::ZERO, &Wavelengths::rgb());
                let mut xyz = [0.0; 3];
                let steps = 200_000;
                for i in 0..steps {
                    let λ = first + (last - first) * ((i as f32 + 0.5) / steps as f32);
                    let light = if factor { f64::from(observer::d65(λ)) } else { 1.0 };
                    let value = 1e-6 * radiance(5000.0, f64::from(λ)) * light;
                    let step = f64::from(last - first) / f64::from(steps) / observer::Y_INTEGRAL;
                    for (sum, matching) in xyz.iter_mut().zip(observer::xyz(λ)) {
                        *sum += f64::from(matching) * value * step;
                    }
                }
                for (found, expected) in found.0.iter().zip(observer::xyz_to_rgb(xyz)) {
                    let (found, expected) = (f64::from(*found), expected.max(0.0));
                    assert!(
                        (found - expected).abs() < 1e-5 * xyz[1],
                        "{first} {usage:?}: {found} {expected}"
                    );
                }
            }
        }
    }
}
