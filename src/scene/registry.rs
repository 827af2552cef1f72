//! Registries: tables with a row for each model, which everything that lists, dispatches or explains models
//! reads.

use super::error::{SceneError, known};
use super::loader::Loader;
use super::params::{Params, Usage};
use super::xml::Element;
use crate::spelling::shortened;

/// One model of some category.
pub struct Entry<T> {
    /// The `type` in scene files.
    pub name: &'static str,
    /// What it is, physically, in a sentence.
    pub about: &'static str,
    /// Scene-file snippets that span its parameters. Each is parsed, tested, listed and compared.
    pub examples: &'static [&'static str],
    pub parse: fn(&mut Params) -> Result<T, SceneError>,
}

/// Reads an element with the model that its `type` names.
pub fn construct<'d, T>(
    table: &[Entry<T>],
    element: &'d Element,
    loader: &Loader<'d>,
    usage: Usage,
) -> Result<T, SceneError> {
    let kind = element.require("type")?;
    let entry = table.iter().find(|e| e.name == kind.value).ok_or_else(|| {
        let names: Vec<&str> = table.iter().map(|e| e.name).collect();
        SceneError::at(
            &kind.value_span,
            format!("unknown {} `{}`", element.tag, shortened(&kind.value)),
            known(&kind.value, &names),
        )
    })?;
    let mut params = Params::new(element, loader, usage)?;
    let model = (entry.parse)(&mut params)?;
    params.finish()?;
    Ok(model)
}
