//! `<spectrum>`: one number, `nm:value` pairs, or a file of them.

use super::error::SceneError;
use super::loader::Loader;
use super::params::number;
use super::xml::{Attribute, Element, read_utf8};
use crate::spectrum::table::Tabulated;

/// The contents of a `<spectrum>`.
pub enum Declared {
    Number(f64),
    Table(Tabulated),
}

/// Reads a `<spectrum>`; also returns the attribute that holds its contents.
pub fn parse<'d>(element: &'d Element, loader: &Loader) -> Result<(Declared, &'d Attribute), SceneError> {
    element.only(&["name", "value", "filename"])?;
    match (element.attribute("value"), element.attribute("filename")) {
        (Some(value), None) if !value.value.contains(':') => {
            let found = number(&value.value).ok_or_else(|| {
                let message = format!("`{}` is no spectrum", value.value);
                SceneError::at(&value.value_span, message, "expected a number or `nm:value` pairs")
            })?;
            Ok((Declared::Number(found), value))
        }
        (Some(value), None) => Ok((Declared::Table(pairs(value)?), value)),
        (None, Some(name)) => {
            let path = loader.find(element, name)?;
            let table = read_utf8(&path).and_then(|text| Tabulated::parse_spd(&text)).map_err(|why| {
                let message = format!("{}: {why}", path.display());
                SceneError::at(&name.value_span, message, "expected lines of `nm value`")
            })?;
            Ok((Declared::Table(table), name))
        }
        _ => Err(SceneError::at(
            &element.span,
            "a <spectrum> needs a value",
            "expected either `value` or `filename`",
        )),
    }
}

fn pairs(attribute: &Attribute) -> Result<Tabulated, SceneError> {
    let wrong =
        |what: String| SceneError::at(&attribute.value_span, what, "expected `nm:value, nm:value, …`");
    let (mut wavelengths, mut values) = (vec![], vec![]);
    let words = attribute.value.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty());
    for word in words {
        let pair = word.split_once(':').and_then(|(λ, v)| Some((number(λ)?, number(v)?)));
        let (λ, value) = pair.ok_or_else(|| wrong(format!("`{word}` is no pair of numbers")))?;
        if [λ, value].iter().any(|v| v.abs() > f64::from(f32::MAX)) {
            return Err(wrong(format!("`{word}` is beyond {:e}", f32::MAX)));
        }
        wavelengths.push(λ as f32);
        values.push(value as f32);
    }
    Tabulated::new(wavelengths, values).map_err(wrong)
}
