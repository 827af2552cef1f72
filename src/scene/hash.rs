//! The hash of a scene.

use super::error::SceneError;
use super::loader::Loader;
use super::xml::{Document, Element};
use crate::spectrum::ColorMode;
use xxhash_rust::xxh3::Xxh3;

/// The hash of the scene's text after substitution, of the colour mode, and of the bytes of every file that
/// it refers to.
pub fn hash(document: &Document, loader: &Loader, mode: ColorMode) -> Result<String, SceneError> {
    let mut hasher = Xxh3::new();
    hasher.update(mode.name().as_bytes());
    hash_element(&document.root, &mut hasher);
    for (alias, id) in &document.aliases {
        hash_text(alias, &mut hasher);
        hash_text(&id.value, &mut hasher);
    }
    for file in loader.files() {
        let bytes = std::fs::read(&file)
            .map_err(|e| SceneError::nowhere(format!("cannot read {}: {e}", file.display())))?;
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(&bytes);
    }
    Ok(format!("{:032x}", hasher.digest128()))
}

fn hash_text(text: &str, hasher: &mut Xxh3) {
    hasher.update(&(text.len() as u64).to_le_bytes());
    hasher.update(text.as_bytes());
}

fn hash_element(element: &Element, hasher: &mut Xxh3) {
    hash_text(&element.tag, hasher);
    hasher.update(&(element.attributes.len() as u64).to_le_bytes());
    for attribute in &element.attributes {
        hash_text(&attribute.name, hasher);
        hash_text(&attribute.value, hasher);
    }
    hasher.update(&(element.children.len() as u64).to_le_bytes());
    for child in &element.children {
        hash_element(child, hasher);
    }
}
