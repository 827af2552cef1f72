//! Values at given wavelengths.

use super::{AnyTexture, color};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::transform::numbers;
use crate::scene::xml::Attribute;
use crate::spectrum::table::Tabulated;

pub const NAME: &str = "irregular";
pub const ABOUT: &str = "Values at given wavelengths, straight lines between them, nothing outside.";
pub const EXAMPLES: &[&str] =
    &[r#"<spectrum type="irregular"><string name="wavelengths" value="400, 500, 700"/>
    <string name="values" value="0.1, 0.2, 0.6"/></spectrum>"#];

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let (wavelengths, _) = number_list(params, "wavelengths", "increasing wavelengths in nm")?;
    let (values, place) = number_list(params, "values", "the value at each")?;
    let table = Tabulated::new(wavelengths, values).map_err(|e| params.error("wavelengths", e, ""))?;
    color::from_table(table, place, params.usage, params.loader).map(AnyTexture::Constant)
}

/// A required list of numbers.
pub fn number_list<'d>(
    params: &mut Params<'_, 'd>,
    name: &'static str,
    about: &'static str,
) -> Result<(Vec<f32>, &'d Attribute), SceneError> {
    let list = params.string(name, about)?;
    let list =
        list.ok_or_else(|| params.error(name, format!("`{name}` is missing"), "add a list of numbers"))?;
    Ok((numbers(list)?.into_iter().map(|v| v as f32).collect(), list))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec2;
    use crate::scene::loader::Loader;
    use crate::scene::params::Usage;
    use crate::scene::xml;
    use crate::spectrum::ColorMode;

    /// Where a number is asked for, as of an opacity, it is the mean over the visible range, whatever is beyond.
    #[test]
    fn as_a_number_it_is_what_is_visible() {
        for (wavelengths, values, expected) in [
            ("850, 900", "1, 1", 0.0),
            ("360, 830, 831, 1000", "0, 0, 1, 1", 0.0),
            ("360, 1000", "0.5, 0.5", 0.5),
        ] {
            let text = format!(
                r#"<scene version="3.0.0"><spectrum type="irregular"><string name="wavelengths" value="{wavelengths}"/>
                <string name="values" value="{values}"/></spectrum></scene>"#
            );
            let document = xml::read_text("t", &text).unwrap();
            let loader = Loader::new(&document, ColorMode::Spectral).unwrap();
            let opacity = AnyTexture::parse(&document.root.children[0], &loader, Usage::Reflectance).unwrap();
            let found = [opacity.eval_scalar(DVec2::ZERO), opacity.scalar().eval_scalar(DVec2::ZERO)];
            assert!(found.iter().all(|v| (v - expected).abs() < 1e-6), "{wavelengths}: {found:?}");
        }
    }
}
