//! What is kept of a run.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file of lines about scenes, to which a run adds its own.
pub struct Record {
    path: PathBuf,
    file: std::fs::File,
}

impl Record {
    /// That of a folder, which is made if need be.
    pub fn within(folder: &Path) -> Result<Self, String> {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let path = folder.join("record.jsonl");
        let file = std::fs::OpenOptions::new().create(true).append(true).open(&path);
        file.map_err(|e| format!("{}: {e}", path.display())).map(|file| Self { path, file })
    }

    pub fn add(&mut self, line: &impl serde::Serialize) -> Result<(), String> {
        let line = serde_json::to_string(line).map_err(|e| e.to_string())?;
        writeln!(self.file, "{line}").map_err(|e| format!("{}: {e}", self.path.display()))
    }
}
