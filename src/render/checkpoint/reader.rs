//! Checkpoints read and looked through: what is damaged, or of another render, is refused.

use super::head::{Head, Identity, OfAnyVersion, Version, another};
use super::{MAGIC, open};
use crate::files::FileError;
use crate::film::{Accumulators, BLOCK, ChannelAccumulator};
use crate::render::Settings;
use crate::render::passes::Partial;
use crate::sampler::SampleId;
use crate::scene::Scene;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::ops::Range;
use std::path::Path;
use xxhash_rust::xxh3::Xxh3;

/// Reads the checkpoint of a render; returns its [`seal`](super::seal) too.
pub fn load(path: &Path, scene: &Scene, settings: &Settings) -> Result<(Partial, u64), FileError> {
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
    if length > file.reader.get_ref().metadata()?.len() {
        return Err(Refused::Input(io::ErrorKind::UnexpectedEof.into()));
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
    (partial.history, partial.light_paths) = (head.history, head.light_paths);
    let report = &mut partial.report;
    report.samples = (head.done - range.start) * settings.window.pixels() as u64;
    (report.rays, report.cut, report.non_finite) = (head.rays, head.cut, head.non_finite);
    let first = head.first_non_finite.into_iter();
    report.first_non_finite = first.map(|(x, y, sample)| SampleId { pixel: (x, y), sample }).collect();
    Ok((partial, seal))
}
