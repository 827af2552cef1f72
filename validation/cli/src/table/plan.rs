//! What the table asks: `validation/table.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

/// The file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// The renderer that all others are compared with.
    pub ours: String,
    /// Mitsuba's variants and samplers; the best of them is the baseline.
    pub mitsuba: Vec<String>,
    /// All other renderers; the best of them is the other baseline.
    pub others: Vec<String>,
    pub class: BTreeMap<String, Class>,
    pub scene: Vec<Entry>,
}

/// Scenes that are hard for the same reason, and the ratios that are aimed at.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Class {
    pub title: String,
    pub mitsuba: f64,
    pub others: f64,
}

/// A scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    pub name: String,
    pub file: String,
    pub class: String,
    /// Width and height of the film.
    pub size: [u32; 2],
}

/// The committed file.
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../table.toml")
}

/// Reads a plan, whose scenes must have known classes.
pub fn load(path: &Path) -> Result<Plan, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let plan: Plan = toml::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    match plan.scene.iter().find(|entry| !plan.class.contains_key(&entry.class)) {
        Some(entry) => Err(format!("{}: {}: no class {:?}", path.display(), entry.name, entry.class)),
        None => Ok(plan),
    }
}

impl Plan {
    /// All renderers, ours first.
    pub fn renderers(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.ours).chain(&self.mitsuba).chain(&self.others)
    }
}

impl Entry {
    /// The scene's file; `shared` is the folder of the scenes that are not the repository's.
    pub fn path(&self, shared: &Path) -> PathBuf {
        match self.file.strip_prefix("shared:") {
            Some(rest) => shared.join(rest),
            None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(&self.file),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_plan_names_known_renderers_and_present_scenes() {
        let plan = load(&file()).unwrap();
        let known = crate::renderers::load(&crate::renderers::file()).unwrap();
        assert!(plan.renderers().all(|name| known.contains_key(name)));
        let own = plan.scene.iter().filter(|entry| !entry.file.starts_with("shared:"));
        assert_eq!(own.filter(|entry| entry.path(Path::new("")).is_file()).count(), 10);
        let mut names: Vec<&String> = plan.scene.iter().map(|entry| &entry.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), plan.scene.len());
    }
}
