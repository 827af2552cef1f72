//! The checkpoint of a render, as far as it is that render's: several may have been given one name.

use super::reader::load;
use super::{refuse_to_replace, save, seal};
use crate::files::FileError;
use crate::render::Settings;
use crate::render::passes::Partial;
use crate::scene::Scene;
use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};

/// The file is replaced and removed as long as it is what this process has written or begun from.
pub struct OwnCheckpoint {
    path: PathBuf,
    /// What it is known by; `None` as long as there is none.
    seal: Cell<Option<u64>>,
}

impl OwnCheckpoint {
    /// For a render that begins at the beginning.
    ///
    /// # Errors
    /// If there is a file: a checkpoint is work that would be lost, and anything else is not ours.
    pub fn begin(path: &Path) -> Result<Self, FileError> {
        refuse_to_replace(path)?;
        Ok(Self { path: path.to_owned(), seal: Cell::new(None) })
    }

    /// For a render that goes on from it.
    ///
    /// # Errors
    /// If it cannot be read, is damaged, or is that of another render; with one sentence that names the file.
    pub fn resume(path: &Path, scene: &Scene, settings: &Settings) -> Result<(Self, Partial), FileError> {
        let (partial, seal) = load(path, scene, settings)?;
        Ok((Self { path: path.to_owned(), seal: Cell::new(Some(seal)) }, partial))
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether there is a file.
    ///
    /// # Errors
    /// If it is another's, or cannot be read.
    pub fn exists(&self) -> Result<bool, FileError> {
        let there = seal(&self.path)?;
        if there.is_some() && there != self.seal.get() {
            return Err(FileError::new(&self.path, "another process has written it since this render began"));
        }
        Ok(there.is_some())
    }

    /// Saves a render in progress.
    ///
    /// # Errors
    /// If it cannot be written, or has become another's, also meanwhile; what is there then stays as it is.
    pub fn save(&self, scene: &Scene, settings: &Settings, partial: &Partial) -> Result<(), FileError> {
        self.exists()?;
        let seal = save(&self.path, scene, settings, partial, || self.exists().map(drop))?;
        self.seal.set(Some(seal));
        Ok(())
    }

    /// Removes it. A render that was too short to save one does not know what is there, and leaves it.
    ///
    /// # Errors
    /// If it cannot be removed, or is another's.
    pub fn remove(&self) -> Result<(), FileError> {
        if self.seal.get().is_some() && self.exists()? {
            fs::remove_file(&self.path).map_err(|error| FileError::new(&self.path, error))?;
        }
        Ok(())
    }
}
