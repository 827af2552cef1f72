//! Checkpoints: a render in progress, in a file: the exact sums so far and what they are sums of.
//!
//! The file is a magic number, the length of the head (`u64`), the head (JSON), the words of the accumulators
//! pixel by pixel and channel by channel (`u32`), and the XXH3 of everything before (`u64`); all numbers
//! little-endian. It is replaced whole or not at all, so a process may die at any time.

mod own;

pub use own::OwnCheckpoint;

use super::Settings;
use super::batch_means::BatchMeans;
use super::light_path_noise::LightPathNoise;
use super::passes::Partial;
use crate::files::{FileError, write_file_unless};
use crate::film::{Accumulators, BLOCK, ChannelAccumulator};
use crate::sampler::SampleId;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;
use xxhash_rust::xxh3::Xxh3;

const MAGIC: &[u8; 8] = b"etalonCP";

/// Length of the longest head, in bytes; it holds a name for each channel.
const LONGEST_HEAD: u64 = 1 << 24;

/// What a checkpoint says of itself before the sums.
#[derive(Serialize, Deserialize)]
struct Head {
    identity: Identity,
    /// Samples of every pixel that are in the sums: from the beginning of the range to this one.
    done: u64,
    rays: u64,
    cut: u64,
    non_finite: u64,
    /// Column, row, sample.
    first_non_finite: Vec<(u32, u32, u64)>,
    means: BatchMeans,
    light_paths: LightPathNoise,
}

/// Everything that decides the image. Two equal ones are the same render; threads and the kernel decide
/// nothing. The version is looked at before all else, for with another one anything else may mean something else.
#[derive(Serialize, Deserialize)]
struct Identity {
    version: String,
    seed: u32,
    samples: (u64, u64),
    film: (u32, u32),
    /// First column and row, columns, rows.
    window: (u32, u32, u32, u32),
    integrator: String,
    channels: Vec<String>,
    /// Hash of the scene. It covers the seed and the integrator too, so it says the least and comes last.
    scene: String,
}

impl Identity {
    fn new(scene: &Scene, settings: &Settings, channels: &[String]) -> Self {
        let w = settings.window;
        Self {
            version: crate::VERSION.into(),
            seed: settings.seed,
            samples: (settings.samples.start, settings.samples.end),
            film: scene.sensor.film.size,
            window: (w.x, w.y, w.width, w.height),
            integrator: scene.integrator.name().into(),
            channels: channels.to_vec(),
            scene: scene.hash.clone(),
        }
    }

    /// The first difference between the checkpoint's render (`self`) and the one that is asked for.
    fn difference(&self, asked: &Identity) -> Option<String> {
        let list = |i: &Identity| {
            let (x, y, width, height) = i.window;
            [
                ("seed", i.seed.to_string()),
                ("range of samples", format!("{}..{}", i.samples.0, i.samples.1)),
                ("film", format!("{}x{}", i.film.0, i.film.1)),
                ("crop", format!("{x},{y},{width},{height}")),
                ("integrator", i.integrator.clone()),
                ("list of channels", i.channels.join(" ")),
                ("scene", i.scene.clone()),
            ]
        };
        let pairs = list(self).into_iter().zip(list(asked));
        pairs
            .filter(|(ours, theirs)| ours.1 != theirs.1)
            .map(|((name, ours), (_, theirs))| another(name, &ours, &theirs))
            .next()
    }
}

/// The part of a head that all versions have.
#[derive(Deserialize)]
struct OfAnyVersion {
    identity: Version,
}

#[derive(Deserialize)]
struct Version {
    version: String,
}

fn another(name: &str, ours: &str, theirs: &str) -> String {
    format!("it is of another {name}: `{ours}`, and `{theirs}` is asked for")
}

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
        means: partial.means.clone(),
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

/// Reads the checkpoint of a render; returns its [`seal`] too.
fn load(path: &Path, scene: &Scene, settings: &Settings) -> Result<(Partial, u64), FileError> {
    read(path, scene, settings).map_err(|refused| refused.at(path))
}

/// The range of samples of the render that a checkpoint is of, where a pilot has chosen it.
///
/// # Errors
/// If it cannot be read, is damaged at its beginning, or no pilot has chosen such samples; with one sentence
/// that names the file.
pub fn chosen_samples(path: &Path) -> Result<Range<u64>, FileError> {
    let chosen = |(start, end)| match start {
        0 => Ok(start..end),
        _ => Err(Refused::Other(format!(
            "it is of samples {start}..{end}, and those that a pilot chooses begin with 0; use --samples"
        ))),
    };
    begin(path).and_then(|(_, head)| chosen(head.identity.samples)).map_err(|refused| refused.at(path))
}

enum Refused {
    Input(io::Error),
    Damaged(&'static str),
    Other(String),
}

impl Refused {
    fn at(self, path: &Path) -> FileError {
        let cause = match self {
            Self::Input(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                "the checkpoint is damaged: it ends too early".into()
            }
            Self::Input(e) => format!("the checkpoint cannot be read: {e}"),
            Self::Damaged(why) => format!("the checkpoint is damaged: {why}"),
            Self::Other(why) => format!("the checkpoint cannot be resumed: {why}"),
        };
        FileError::new(path, cause)
    }
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        Self::Input(error)
    }
}

/// A reader that hashes what it reads.
struct Hashed<R> {
    reader: R,
    hash: Xxh3,
}

impl<R: Read> Hashed<R> {
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.reader.read_exact(bytes)?;
        self.hash.update(bytes);
        Ok(())
    }
}

/// Reads all that is before the sums.
fn begin(path: &Path) -> Result<(Hashed<BufReader<File>>, Head), Refused> {
    let mut file = Hashed { reader: BufReader::with_capacity(1 << 20, open(path)?), hash: Xxh3::new() };
    let mut word = [0; 8];
    file.fill(&mut word)?;
    if &word != MAGIC {
        return Err(Refused::Other("it is no checkpoint of Etalon's".into()));
    }
    file.fill(&mut word)?;
    let length = u64::from_le_bytes(word);
    if length > LONGEST_HEAD {
        return Err(Refused::Damaged("its head is too long"));
    }
    let mut head = vec![0; length as usize];
    file.fill(&mut head)?;
    let damaged = |_| Refused::Damaged("its head cannot be understood");
    let OfAnyVersion { identity: Version { version } } = serde_json::from_slice(&head).map_err(damaged)?;
    if version != crate::VERSION {
        return Err(Refused::Other(another("version", &version, crate::VERSION)));
    }
    Ok((file, serde_json::from_slice(&head).map_err(damaged)?))
}

fn read(path: &Path, scene: &Scene, settings: &Settings) -> Result<(Partial, u64), Refused> {
    let (mut file, head) = begin(path)?;
    let mut partial = Partial::new(scene, settings);
    if let Some(why) = head.identity.difference(&Identity::new(scene, settings, &partial.channels)) {
        return Err(Refused::Other(why));
    }
    let range = &settings.samples;
    let reachable = head.done == range.end || head.done.is_multiple_of(BLOCK) && range.contains(&head.done);
    if !reachable {
        return Err(Refused::Damaged("it claims samples beyond its range"));
    }
    let mut row = vec![0; 4 * Accumulators::WORDS * partial.channels.len() * settings.window.width as usize];
    for y in 0..settings.window.height {
        file.fill(&mut row)?;
        let mut stored = row.chunks_exact(4 * Accumulators::WORDS);
        for x in 0..settings.window.width {
            for (sum, bytes) in partial.sums.pixel_mut(x, y).iter_mut().zip(&mut stored) {
                let word = |i: usize| u32::from_le_bytes(std::array::from_fn(|b| bytes[4 * i + b]));
                *sum = ChannelAccumulator::from_words(&std::array::from_fn(word))
                    .ok_or(Refused::Damaged("one of its sums is not a number"))?;
            }
        }
    }
    let mut word = [0; 8];
    file.reader.read_exact(&mut word)?;
    let seal = u64::from_le_bytes(word);
    if seal != file.hash.digest() {
        return Err(Refused::Damaged("its checksum is wrong"));
    }
    if file.reader.read(&mut word)? > 0 {
        return Err(Refused::Damaged("something follows its end"));
    }
    partial.samples.end = head.done;
    (partial.means, partial.light_paths) = (head.means, head.light_paths);
    let report = &mut partial.report;
    report.samples = (head.done - range.start) * settings.window.pixels() as u64;
    (report.rays, report.cut, report.non_finite) = (head.rays, head.cut, head.non_finite);
    let first = head.first_non_finite.into_iter();
    report.first_non_finite = first.map(|(x, y, sample)| SampleId { pixel: (x, y), sample }).collect();
    Ok((partial, seal))
}

#[cfg(test)]
mod tests;
