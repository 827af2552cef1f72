//! What the command line says instead of the scene file, written into the document before anything reads it:
//! so it takes the same path, gives the same errors, and is part of the scene's hash.

use super::Overrides;
use super::error::SceneError;
use super::xml::{Attribute, Document, Element};

pub fn apply(document: &mut Document, overrides: &Overrides) -> Result<(), SceneError> {
    let root = &mut document.root;
    if let Some(name) = &overrides.integrator {
        root.children.retain(|c| c.tag != "integrator");
        let integrator = element(root, "integrator", &[("type", name)]);
        root.children.push(integrator);
    }
    if let Some(depth) = overrides.max_depth {
        let integrator = child(root, "integrator", "path")?;
        set(integrator, "max_depth", &depth.to_string());
    }
    if let Some(share) = overrides.light_paths {
        let integrator = child(root, "integrator", "path")?;
        set_as("float", integrator, "light_paths", &share.to_string());
    }
    if let Some(pixels) = overrides.reuse {
        set(child(root, "integrator", "path")?, "reuse", &pixels.to_string());
    }
    if let Some(count) = overrides.shared_light_paths {
        set(child(root, "integrator", "path")?, "shared_light_paths", &count.to_string());
    }
    if let Some(place) = &overrides.links {
        set_as("string", child(root, "integrator", "path")?, "links", place);
    }
    if let Some((width, height)) = overrides.size {
        let film = child(child(root, "sensor", "")?, "film", "hdrfilm")?;
        let crop = ["crop_offset_x", "crop_offset_y", "crop_width", "crop_height"];
        film.children.retain(|c| !c.name().is_some_and(|n| crop.contains(&n)));
        set(film, "width", &width.to_string());
        set(film, "height", &height.to_string());
    }
    if let Some(name) = &overrides.sampler {
        let sampler = child(child(root, "sensor", "")?, "sampler", "sobol")?;
        for attribute in sampler.attributes.iter_mut().filter(|a| a.name == "type") {
            attribute.value.clone_from(name);
        }
    }
    if let Some(seed) = overrides.seed {
        let sampler = child(child(root, "sensor", "")?, "sampler", "sobol")?;
        set(sampler, "seed", &seed.to_string());
    }
    Ok(())
}

/// The child object of a kind, made where it is missing.
fn child<'a>(parent: &'a mut Element, tag: &str, kind: &str) -> Result<&'a mut Element, SceneError> {
    let found = parent.children.iter().position(|c| c.tag == tag);
    let index = match found {
        Some(index) => index,
        None if kind.is_empty() => {
            return Err(SceneError::at(
                &parent.span,
                format!("the scene has no {tag}"),
                format!("add a <{tag}>"),
            ));
        }
        None => {
            let made = element(parent, tag, &[("type", kind)]);
            parent.children.push(made);
            parent.children.len() - 1
        }
    };
    Ok(&mut parent.children[index])
}

/// Sets an integer parameter.
fn set(parent: &mut Element, name: &str, value: &str) {
    set_as("integer", parent, name, value);
}

fn set_as(kind: &str, parent: &mut Element, name: &str, value: &str) {
    parent.children.retain(|c| c.name() != Some(name));
    let parameter = element(parent, kind, &[("name", name), ("value", value)]);
    parent.children.push(parameter);
}

/// A new element that claims to stand where `place` does.
fn element(place: &Element, tag: &str, attributes: &[(&str, &str)]) -> Element {
    let attribute = |(name, value): &(&str, &str)| Attribute {
        name: (*name).into(),
        value: (*value).into(),
        name_span: place.span.clone(),
        value_span: place.span.clone(),
    };
    Element {
        tag: tag.into(),
        attributes: attributes.iter().map(attribute).collect(),
        children: vec![],
        span: place.span.clone(),
        search: place.search.clone(),
    }
}
