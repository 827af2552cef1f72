//! The catalogue: `validation/museum/bugs/*.json`, lists of bugs.

use super::plant::Change;
use crate::files;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A bug as the catalogue describes it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bug {
    pub name: String,
    /// The name of its file in the catalogue.
    #[serde(skip)]
    pub chapter: String,
    /// What is wrong, in a sentence.
    pub about: String,
    /// Who has made the bug before, with a number and an address; or why one might make it.
    pub source: String,
    /// The source file, relative to the root of the repository.
    pub file: String,
    /// A piece of the file that occurs once and holds the expression; the expression itself by default.
    #[serde(default)]
    pub within: Option<String>,
    /// The correct expression, which occurs once in `within`.
    pub find: String,
    /// The wrong expression, of the same type.
    pub replace: String,
}

/// The folder of the catalogue.
pub fn folder() -> PathBuf {
    super::root().join("validation/museum/bugs")
}

/// All bugs, in the order of the files' names.
pub fn catalogue(folder: &Path) -> Result<Vec<Bug>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    paths.sort();
    let mut bugs = vec![];
    for path in paths {
        let list: Vec<Bug> = files::json(&path)?;
        let chapter = path.file_stem().unwrap_or_default().to_string_lossy();
        bugs.extend(list.into_iter().map(|bug| Bug { chapter: chapter.to_string(), ..bug }));
    }
    Ok(bugs)
}

impl Bug {
    /// The change to the tree below `root`. Error: the source no longer contains exactly one such expression.
    pub fn change(&self, root: &Path) -> Result<Change, String> {
        let path = root.join(&self.file);
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let within = self.within.as_ref().unwrap_or(&self.find);
        let start = only(&text, within).map_err(|count| self.complaint(within, count))?;
        let offset = only(within, &self.find).map_err(|count| self.complaint(&self.find, count))?;
        Ok(Change {
            name: self.name.clone(),
            about: self.about.clone(),
            source: self.source.clone(),
            file: self.file.clone(),
            chapter: Some(self.chapter.clone()),
            range: start + offset..start + offset + self.find.len(),
            replace: self.replace.clone(),
        })
    }

    fn complaint(&self, piece: &str, count: usize) -> String {
        format!("{}: `{piece}` occurs {count} times in {}, not once", self.name, self.file)
    }
}

/// The position of a piece, or the number of its occurrences if that is not one.
fn only(text: &str, piece: &str) -> Result<usize, usize> {
    let mut places = text.match_indices(piece);
    match (places.next(), places.next()) {
        (Some((at, _)), None) => Ok(at),
        (None, _) => Err(0),
        _ => Err(2 + places.count()),
    }
}
