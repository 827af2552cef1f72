//! The scenes and renderers of the table: `validation/table.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

/// The content of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// The renderer that all others are compared with.
    pub ours: String,
    /// Mitsuba's variants and samplers; the most efficient of them is the baseline.
    pub mitsuba: Vec<String>,
    /// All other renderers; the most efficient of them is the other baseline.
    pub others: Vec<String>,
    pub class: BTreeMap<String, Class>,
    pub scene: Vec<Entry>,
}

/// Scenes that are hard for the same reason, with the efficiency ratios that are aimed at.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Class {
    pub title: String,
    /// The ratio that is aimed at over the best of Mitsuba.
    pub mitsuba: f64,
    /// The ratio that is aimed at over the best of the other renderers.
    pub others: f64,
}

/// A scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    pub name: String,
    pub file: String,
    pub class: String,
    /// Source of a scene that is not in the repository.
    #[serde(default)]
    pub from: String,
    /// Width and height of the film in pixels.
    pub size: [u32; 2],
    /// The film's reconstruction filter, whatever the scene has.
    #[serde(default = "uncorrelated")]
    pub filter: String,
}

/// The filter that leaves the errors of pixels independent.
fn uncorrelated() -> String {
    "box".into()
}

/// The committed file.
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../table.toml")
}

/// Reads a plan. Errors: an unreadable file, or a scene with an unknown class.
pub fn load(path: &Path) -> Result<Plan, String> {
    let plan: Plan = crate::files::toml(path)?;
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
    /// The scene's file. `shared` is the folder of the scenes that are not in the repository. Error: it is
    /// needed and absent.
    pub fn path(&self, shared: Option<&Path>) -> Result<PathBuf, String> {
        match (self.file.strip_prefix("shared:"), shared) {
            (None, _) => Ok(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(&self.file)),
            (Some(rest), Some(shared)) => Ok(shared.join(rest)),
            (Some(rest), None) => Err(format!("--shared names no folder with {rest} ({})", self.from)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_plans_name_known_renderers_and_present_scenes() {
        let known = crate::renderers::load(&crate::renderers::file()).unwrap();
        for (file, own_scenes) in [(file(), 10), (file().with_file_name("converge/rooms.toml"), 0)] {
            let plan = load(&file).unwrap();
            assert!(plan.renderers().all(|name| known.contains_key(name)));
            let (own, others): (Vec<&Entry>, Vec<&Entry>) =
                plan.scene.iter().partition(|entry| entry.path(None).is_ok());
            let present = own.iter().filter(|entry| entry.path(None).is_ok_and(|path| path.is_file()));
            assert_eq!(present.count(), own_scenes);
            assert!(others.iter().all(|entry| entry.path(None).is_err_and(|why| why.contains(&entry.from))));
            assert!(others.iter().all(|entry| !entry.from.is_empty()));
            let mut names: Vec<&String> = plan.scene.iter().map(|entry| &entry.name).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), plan.scene.len());
        }
    }
}
