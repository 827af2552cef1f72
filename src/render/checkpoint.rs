//! Checkpoints: a render in progress, in a file: the exact sums so far and what they are sums of.
//!
//! The file is a magic number, the length of the head (`u64`), the head (JSON), the words of the accumulators
//! pixel by pixel and channel by channel (`u32`), and the XXH3 of everything before (`u64`); all numbers
//! little-endian. It is replaced whole or not at all, so a process may die at any time.

mod head;
mod own;
mod reader;

use head::{Head, Identity};
pub use own::OwnCheckpoint;
pub use reader::chosen_samples;

use super::Settings;
use super::passes::Partial;
use crate::files::{FileError, write_file_unless};
use crate::film::Accumulators;
use crate::scene::Scene;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use xxhash_rust::xxh3::Xxh3;

const MAGIC: &[u8; 8] = b"etalonCP";

/// Length of the file in bytes, without its head.
pub fn size(settings: &Settings, channels: usize) -> u64 {
    4 * (Accumulators::WORDS * channels * settings.window.pixels()) as u64
}

/// Refuses to begin a render over a file that exists, and says what it is.
fn refuse_to_replace(path: &Path) -> Result<(), FileError> {
    let error = |cause: String| Err(FileError::new(path, cause));
    match std::fs::metadata(path) {
        Err(why) if why.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(why) => return error(why.to_string()),
        Ok(metadata) if !metadata.is_file() => return error("it is no regular file".into()),
        Ok(_) => {}
    }
    let mut magic = [0; MAGIC.len()];
    let ours = File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok() && magic == *MAGIC;
    let cause = match ours {
        true => "there is a checkpoint already; go on from it with --resume, or remove it",
        false => "there is a file already, and it is no checkpoint",
    };
    error(cause.into())
}

/// What tells a file from every other: the checksum at its end. `None` if there is no file.
fn seal(path: &Path) -> Result<Option<u64>, FileError> {
    let mut word = [0; 8];
    let read = |mut file: File| {
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(word.len() as u64)))?;
        file.read_exact(&mut word)
    };
    match open(path).and_then(read) {
        Ok(()) => Ok(Some(u64::from_le_bytes(word))),
        Err(why) if why.kind() == io::ErrorKind::NotFound => Ok(None),
        // Shorter than any checkpoint.
        Err(why) if why.kind() == io::ErrorKind::UnexpectedEof => Ok(Some(0)),
        Err(why) => Err(FileError::new(path, why)),
    }
}

/// Opens a regular file; to open a pipe would wait for who writes it.
fn open(path: &Path) -> io::Result<File> {
    match std::fs::metadata(path)?.is_file() {
        true => File::open(path),
        false => Err(io::Error::other("it is no regular file")),
    }
}

/// Saves a render in progress; returns the file's [`seal`]. `may_replace` is asked when all is written. An error
/// leaves an older checkpoint as it was.
fn save(
    path: &Path,
    scene: &Scene,
    settings: &Settings,
    partial: &Partial,
    may_replace: impl FnOnce() -> Result<(), FileError>,
) -> Result<u64, FileError> {
    let mut seal = 0;
    let report = &partial.report;
    let head = Head {
        identity: Identity::new(scene, settings, &partial.channels),
        done: partial.samples.end,
        rays: report.rays,
        cut: report.cut,
        non_finite: report.non_finite,
        first_non_finite: report.first_non_finite.iter().map(|n| (n.pixel.0, n.pixel.1, n.sample)).collect(),
        history: partial.history.clone(),
        light_paths: partial.light_paths,
    };
    let head = serde_json::to_vec(&head).map_err(|error| FileError::new(path, error))?;
    let write = |file: &mut dyn Write| {
        let mut hash = Xxh3::new();
        let mut put = |bytes: &[u8]| {
            hash.update(bytes);
            file.write_all(bytes)
        };
        put(MAGIC)?;
        put(&(head.len() as u64).to_le_bytes())?;
        put(&head)?;
        let mut row = vec![];
        for y in 0..partial.sums.height() {
            row.clear();
            for x in 0..partial.sums.width() {
                for sum in partial.sums.pixel(x, y) {
                    (0..Accumulators::WORDS).for_each(|i| row.extend(sum.word(i).to_le_bytes()));
                }
            }
            put(&row)?;
        }
        seal = hash.digest();
        file.write_all(&seal.to_le_bytes())
    };
    write_file_unless(path, write, may_replace)?;
    Ok(seal)
}

#[cfg(test)]
mod tests;
