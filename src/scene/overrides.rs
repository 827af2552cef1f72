//! Overrides of the scene file by the command line, written into the document before anything reads it: so
//! they are read in the same way, give the same errors, and are part of the scene's hash.

mod place;

use super::error::SceneError;
use super::xml::{Document, Element};
use place::{Place, at, inner, sensors};

/// What a command line overrides of the scene file.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Name of an integrator, which has its default settings.
    pub integrator: Option<String>,
    /// Edges of the longest path; −1 means no limit.
    pub max_depth: Option<i64>,
    /// Which of the scene's sensors, counted from 0, instead of the first.
    pub sensor: Option<usize>,
    /// Film size; the crop window becomes the whole film.
    pub size: Option<(u32, u32)>,
    pub seed: Option<u32>,
    /// Name of a sampler.
    pub sampler: Option<String>,
    /// Light paths per camera path.
    pub light_paths: Option<f64>,
    /// Number of pixels that share what their paths find.
    pub reuse: Option<u32>,
    /// Light paths per group of pixels that share.
    pub shared_light_paths: Option<u32>,
    /// At which vertices emitters are sampled through glass and by mirrors.
    pub links: Option<String>,
}

/// Writes what the command line says into the document.
pub fn apply(document: &mut Document, overrides: &Overrides) -> Result<(), SceneError> {
    let root = &mut document.root;
    if let Some(name) = &overrides.integrator {
        root.children.retain(|c| c.tag != "integrator");
        let integrator = Element::made_at(root, "integrator", &[("type", name)]);
        root.children.push(integrator);
    }
    let settings = [
        ("integer", "max_depth", overrides.max_depth.map(|depth| depth.to_string())),
        ("float", "light_paths", overrides.light_paths.map(|share| share.to_string())),
        ("integer", "reuse", overrides.reuse.map(|pixels| pixels.to_string())),
        ("integer", "shared_light_paths", overrides.shared_light_paths.map(|count| count.to_string())),
        ("string", "links", overrides.links.clone()),
    ];
    for (kind, name, value) in settings {
        if let Some(value) = value {
            let integrator = integrator(document);
            if name != "max_depth" {
                require_path(integrator, name)?;
            }
            set(kind, integrator, name, &value);
        }
    }
    if let Some(number) = overrides.sensor {
        put_first(document, number)?;
    }
    if let Some((width, height)) = overrides.size {
        let film = of_sensor(document, "film", "hdrfilm")?;
        let crop = ["crop_offset_x", "crop_offset_y", "crop_width", "crop_height"];
        film.children.retain(|c| !c.name().is_some_and(|n| crop.contains(&n)));
        set("integer", film, "width", &width.to_string());
        set("integer", film, "height", &height.to_string());
    }
    if let Some(name) = &overrides.sampler {
        let sampler = of_sensor(document, "sampler", "sobol")?;
        for attribute in sampler.attributes.iter_mut().filter(|a| a.name == "type") {
            attribute.value.clone_from(name);
        }
    }
    if let Some(seed) = overrides.seed {
        set("integer", of_sensor(document, "sampler", "sobol")?, "seed", &seed.to_string());
    }
    Ok(())
}

/// Puts a sensor, or the shape that it is in, before the others: the first is used.
fn put_first(document: &mut Document, number: usize) -> Result<(), SceneError> {
    let sensors = sensors(document);
    let Some((chosen, _)) = sensors.get(number) else {
        let last = sensors.len().saturating_sub(1);
        let message = format!("the scene has no sensor number {number}");
        return Err(SceneError::at(&document.root.span, message, format!("expected 0 to {last}")));
    };
    let first = sensors[0].0;
    document.root.children[first..=*chosen].rotate_right(1);
    Ok(())
}

/// The integrator that makes the image: the innermost, within those that nest another one.
fn integrator(document: &mut Document) -> &mut Element {
    let mut place = child_or_new(document, &[], "integrator", "path");
    let mut seen = vec![];
    // One that contains itself is refused when it is read.
    while let Some(nested) = inner(document, &place, "integrator").filter(|nested| !seen.contains(nested)) {
        seen.push(nested.clone());
        place = nested;
    }
    at(&mut document.root, &place)
}

/// Refuses an option that only `path` has where the integrator is another: the file has no such parameter whose place
/// an error could name.
fn require_path(integrator: &Element, name: &str) -> Result<(), SceneError> {
    let Some(kind) = integrator.attribute("type").filter(|kind| kind.value != "path") else { return Ok(()) };
    let message =
        format!("--{} is for the integrator `path`, and this is `{}`", name.replace('_', "-"), kind.value);
    Err(SceneError::at(&kind.value_span, message, "expected it without that option"))
}

/// An object of the first sensor, made where it is missing.
fn of_sensor<'a>(document: &'a mut Document, tag: &str, kind: &str) -> Result<&'a mut Element, SceneError> {
    let sensors = sensors(document);
    let (_, sensor) = sensors
        .first()
        .ok_or_else(|| SceneError::at(&document.root.span, "the scene has no sensor", "add a <sensor>"))?;
    let place = child_or_new(document, sensor, tag, kind);
    Ok(at(&mut document.root, &place))
}

/// The object of a kind within another, made where it is missing.
fn child_or_new(document: &mut Document, parent: &[usize], tag: &str, kind: &str) -> Place {
    inner(document, parent, tag).unwrap_or_else(|| {
        let parent_element = at(&mut document.root, parent);
        let made = Element::made_at(parent_element, tag, &[("type", kind)]);
        parent_element.children.push(made);
        [parent, &[parent_element.children.len() - 1]].concat()
    })
}

/// Sets a parameter of a kind in its place. One that says the same already stays as it is, and so does the scene's hash.
fn set(kind: &str, parent: &mut Element, name: &str, value: &str) {
    let says = |c: &Element| c.tag == kind && c.attribute("value").is_some_and(|said| said.value == value);
    let is_it = |c: &Element| c.name() == Some(name);
    let place = parent.children.iter().position(is_it).unwrap_or(parent.children.len());
    if parent.children.get(place).is_some_and(says) {
        return;
    }
    let parameter = Element::made_at(parent, kind, &[("name", name), ("value", value)]);
    parent.children.retain(|c| !is_it(c));
    parent.children.insert(place, parameter);
}

#[cfg(test)]
mod tests;
