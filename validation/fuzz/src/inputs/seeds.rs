//! Seed files, which are valid, and the inputs that mutations make of them.

use super::Format;
use super::mutate::LONGEST;
use crate::draw::Draw;
use std::path::{Path, PathBuf};

/// The seed files of a format, in an order that does not depend on the machine.
pub struct Seeds(Vec<Vec<u8>>);

/// Folders of this repository that hold files of the formats.
pub fn folders() -> Vec<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    ["regressions", "seeds", "../references/scenes", "../../scenes"].map(|folder| here.join(folder)).into()
}

impl Seeds {
    /// Reads the files of the format in these folders and below, up to [`LONGEST`] bytes each. Errors: an
    /// unreadable folder or file, or no seed at all.
    pub fn read(format: &Format, folders: &[PathBuf]) -> Result<Self, String> {
        let mut files = vec![];
        for folder in folders {
            let mut found = vec![];
            collect(folder, &mut found)?;
            found.sort();
            files.extend(found);
        }
        let suits =
            |path: &PathBuf| path.extension().is_some_and(|e| format.extensions.iter().any(|x| e == *x));
        let mut seeds = vec![];
        for file in files.iter().filter(|file| suits(file)) {
            let bytes = std::fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
            if bytes.len() <= LONGEST {
                seeds.push(bytes);
            }
        }
        if seeds.is_empty() { Err(format!("no seeds for {}", format.name)) } else { Ok(Self(seeds)) }
    }

    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Input `number`: first the seeds unchanged, then seeds with a few mutations.
    pub fn input(&self, format: &Format, number: u64) -> Vec<u8> {
        if let Some(seed) = usize::try_from(number).ok().and_then(|n| self.0.get(n)) {
            return seed.clone();
        }
        let mut draw = Draw::named(format.name, number);
        let mut data = draw.of(&self.0).clone();
        for _ in 0..draw.few(12) {
            let other = draw.of(&self.0);
            data = (format.mutate)(data, other, &mut draw);
            data.truncate(LONGEST);
        }
        data
    }
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for path in entries.filter_map(Result::ok).map(|entry| entry.path()) {
        if path.is_dir() { collect(&path, found)? } else { found.push(path) }
    }
    Ok(())
}
