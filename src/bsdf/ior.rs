//! Indices of refraction as scene files give them: a number, the name of a material, or a dispersion law.

use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::{Params, number};
use crate::scene::spectrum::{self, Declared};
use crate::scene::transform::numbers;
use crate::scene::xml::{Attribute, Element};
use crate::spectrum::materials::{self, Dispersion};

/// Indices of refraction whose ratios leave room for their squares, also in `f32`.
pub const RANGE: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

const INTERIOR: &str = "index of refraction inside, or the name of a material";
const EXTERIOR: &str = "index of refraction outside, on the normal's side, or the name of a material";

/// Reads `int_ior` and `ext_ior`: η inside / η outside. `interior` names the material that is the default
/// inside.
pub fn relative(params: &mut Params, interior: &'static str) -> Result<f64, SceneError> {
    Ok(one(params, "int_ior", interior, INTERIOR)? / exterior(params)?)
}

/// Whether two sides have the same index, or so nearly that the half vector of refraction, ωₒ + ηωᵢ, is rounding.
pub fn nearly_equal(eta: f64) -> bool {
    (eta - 1.0).abs() < 1e-12
}

/// Refuses two sides of the same index, where refraction has no half vector.
pub fn refuse_equal(params: &Params, eta: f64) -> Result<(), SceneError> {
    let message = "the indices of refraction are the same on both sides";
    let refusal = || params.error("int_ior", message, "expected them to differ; `null` is no surface");
    if nearly_equal(eta) { Err(refusal()) } else { Ok(()) }
}

fn exterior(params: &mut Params) -> Result<f64, SceneError> {
    one(params, "ext_ior", "air", EXTERIOR)
}

fn one(
    params: &mut Params,
    name: &'static str,
    default: &'static str,
    about: &'static str,
) -> Result<f64, SceneError> {
    match params.raw(name, "float | string", default, about)? {
        Some(element) => scalar(element),
        None => materials::dielectric(default).map_err(|help| params.error(name, "no default", help)),
    }
}

/// The index that `<float>` or `<string>` gives.
fn scalar(element: &Element) -> Result<f64, SceneError> {
    element.only(&["name", "value"])?;
    let value = element.require("value")?;
    let wrong = |message: String, expected: &str| Err(SceneError::at(&value.value_span, message, expected));
    match element.tag.as_str() {
        "float" | "integer" => {
            number(&value.value).filter(|n| RANGE.contains(n)).ok_or_else(|| no_index(value))
        }
        "string" => materials::dielectric(&value.value)
            .or_else(|help| wrong(format!("unknown material `{}`", value.value), &help)),
        tag => wrong(format!("an index of refraction cannot be a <{tag}>"), "expected <float> or <string>"),
    }
}

/// How a smooth interface refracts.
#[derive(Clone, Debug)]
pub enum Index {
    /// η inside / η outside at all wavelengths.
    Constant(f64),
    /// The inside disperses, and the number is the index outside.
    Dispersive(Dispersion, f64),
}

/// Reads `int_ior` or one of the dispersion laws, and `ext_ior`.
pub fn dispersive(params: &mut Params, interior: &'static str) -> Result<Index, SceneError> {
    let names = ["int_ior", "dispersion", "sellmeier", "cauchy"];
    let given: Vec<&str> = names.into_iter().filter(|name| params.has(name)).collect();
    if let [first, second, ..] = given[..] {
        return Err(params.error(
            second,
            format!("`{second}` beside `{first}`"),
            "expected one description of the inside",
        ));
    }
    let law = law(params)?;
    let outside = exterior(params)?;
    let element = params.raw("int_ior", "float | string | spectrum", interior, INTERIOR)?;
    let law = match (law, element) {
        (Some(law), _) => law,
        (None, Some(element)) if element.tag == "spectrum" => match table(element, params.loader)? {
            Declared::Number(eta) => return Ok(Index::Constant(eta / outside)),
            Declared::Table(table) => Dispersion::Table(table),
        },
        (None, Some(element)) => return Ok(Index::Constant(scalar(element)? / outside)),
        (None, None) => {
            let eta = materials::dielectric(interior)
                .map_err(|help| params.error("int_ior", "no default", help))?;
            return Ok(Index::Constant(eta / outside));
        }
    };
    if let Some((λ, eta)) = law.outside(&RANGE) {
        let message = format!("the index of refraction would be {eta:?} at {} nm", (1e3 * λ).round() / 1e3);
        return Err(params.error(
            given.first().unwrap_or(&"int_ior"),
            message,
            "expected values from 1e-9 to 1e9 between 360 and 830 nm",
        ));
    }
    Ok(Index::Dispersive(law, outside))
}

/// Reads `dispersion`, `sellmeier` or `cauchy`.
fn law(params: &mut Params) -> Result<Option<Dispersion>, SceneError> {
    let about = "a glass inside whose index depends on wavelength (Etalon's own)";
    if let Some(name) = params.string("dispersion", about)? {
        let law = Dispersion::named(&name.value);
        let law = law.map_err(|help| {
            SceneError::at(&name.value_span, format!("unknown glass `{}`", name.value), help)
        });
        return law.map(Some);
    }
    let about = "b1 c1 b2 c2 … of n² = 1 + Σ bλ²/(λ² − c), λ in µm (Etalon's own)";
    if let Some(text) = params.string("sellmeier", about)? {
        let terms = numbers(text)?;
        if terms.is_empty() || terms.len() % 2 == 1 {
            let message = format!("{} numbers", terms.len());
            return Err(SceneError::at(&text.value_span, message, "expected pairs of b and c"));
        }
        return Ok(Some(Dispersion::Sellmeier(
            terms.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect(),
        )));
    }
    let about = "a b c of n = a + b/λ² + c/λ⁴, λ in µm (Etalon's own)";
    if let Some(text) = params.string("cauchy", about)? {
        return match numbers(text)?[..] {
            [a, b] => Ok(Some(Dispersion::Cauchy([a, b, 0.0]))),
            [a, b, c] => Ok(Some(Dispersion::Cauchy([a, b, c]))),
            ref n => {
                let message = format!("{} numbers", n.len());
                Err(SceneError::at(&text.value_span, message, "expected two or three"))
            }
        };
    }
    Ok(None)
}

/// A measured index: `<spectrum>`.
fn table(element: &Element, loader: &Loader) -> Result<Declared, SceneError> {
    let (declared, place) = spectrum::parse(element, loader)?;
    match declared {
        Declared::Number(eta) if !RANGE.contains(&eta) => Err(no_index(place)),
        declared => Ok(declared),
    }
}

fn no_index(place: &Attribute) -> SceneError {
    let expected = format!("expected a number above 0, from {:e} to {:e}", RANGE.start(), RANGE.end());
    SceneError::at(&place.value_span, format!("`{}` is no index of refraction", place.value), expected)
}
