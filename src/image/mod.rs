//! Images in memory and in files: OpenEXR and PNG, provenance, merging.
//!
//! A file is a function of the render: no clock, host name, path or thread count reaches it, so equal renders
//! are equal byte for byte. A *shard*, a render of a part of the samples, carries its exact accumulators
//! along, so that [`merge`] can join shards to the file that one run would have written.

mod attributes;
mod coverage;
mod exr;
mod font;
mod merge;
mod pixels;
mod png;
mod provenance;
pub mod read;
mod sheet;
pub mod srgb;

pub use self::exr::{check_names, read_exr, write_exr};
pub use merge::{merge, merge_files};
pub use pixels::Pixels;
pub use png::{Rgb8, check_developable, develop, encode_png, write_png};
pub use provenance::{Attribute, Provenance};
pub use sheet::contact_sheet;
pub use srgb::encode_srgb;

use crate::files::FileError;
use crate::film::{Accumulators, Window};
use std::fmt;
use std::path::{Path, PathBuf};

/// The channels of an image's colours.
pub const COLOURS: [&str; 3] = ["R", "G", "B"];

/// One channel of an image, pixel by pixel in rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// `R`, `G`, `B`; a spectral bin such as `S0.550,000nm` (Fichet et al. 2021, "An OpenEXR Layout for
    /// Spectral Images"); or the name of an auxiliary output.
    pub name: String,
    /// The mean of the pixel's samples. Linear sRGB in `R G B`, radiance in a spectral bin.
    pub mean: Vec<f32>,
    /// The variance of that mean, if it is known. Infinite where it could not be estimated, or where it
    /// exceeds the range of f32 (a standard error beyond 1.8e19); where it is beneath it (4e-23), the least number
    /// of that range, for zero says that there is no noise.
    pub variance: Option<Vec<f32>>,
}

impl Channel {
    /// The channels of accumulated samples, of which every pixel has as many as told.
    pub(crate) fn all(names: &[String], accumulators: &Accumulators, samples: u64) -> Vec<Channel> {
        let channel = |(index, name): (usize, &String)| Channel {
            name: name.clone(),
            mean: accumulators.channel(index).map(|channel| channel.mean(samples) as f32).collect(),
            variance: Some(
                accumulators
                    .channel(index)
                    .map(|channel| single_variance(channel.variance(samples)))
                    .collect(),
            ),
        };
        names.iter().enumerate().map(channel).collect()
    }
}

/// A variance in the precision of files; positive remains positive.
pub(crate) fn single_variance(variance: f64) -> f32 {
    const LEAST: f32 = f32::from_bits(1);
    if variance > 0.0 { (variance as f32).max(LEAST) } else { variance as f32 }
}

/// A rendered image, whole or a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height of the film in pixels.
    pub full: (u32, u32),
    /// The part of the film that this image covers.
    pub crop: Window,
    /// The channels, in any order, with `crop.pixels()` values each.
    pub channels: Vec<Channel>,
    /// What was rendered and how; absent in files that Etalon has not written.
    pub provenance: Option<Provenance>,
    /// In a shard, the exact sums of each pixel; their channels are those of `channels`.
    pub accumulators: Option<Accumulators>,
}

impl Image {
    /// The image of accumulated samples, with a mean and a variance for each of the named channels. `shard`
    /// says whether the image keeps the accumulators.
    pub fn from_accumulators(
        full: (u32, u32),
        crop: Window,
        names: &[String],
        provenance: Provenance,
        accumulators: Accumulators,
        shard: bool,
    ) -> Image {
        let samples = provenance.samples.end.saturating_sub(provenance.samples.start);
        let channels = Channel::all(names, &accumulators, samples);
        let accumulators = shard.then_some(accumulators);
        Image { full, crop, channels, provenance: Some(provenance), accumulators }
    }

    /// How many pixels have a channel whose mean is not finite.
    pub fn not_finite(&self) -> usize {
        let finite = |i: &usize| self.channels.iter().all(|channel| channel.mean[*i].is_finite());
        (0..self.crop.pixels()).filter(|i| !finite(i)).count()
    }

    /// The channel with this name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }
}

/// Why an image could not be read, written or merged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageError {
    /// The file concerned, if it is a single one.
    pub path: Option<PathBuf>,
    /// What is wrong, in one sentence.
    pub cause: String,
}

impl ImageError {
    fn new(cause: impl fmt::Display) -> ImageError {
        ImageError { path: None, cause: cause.to_string() }
    }

    fn at(mut self, path: &Path) -> ImageError {
        self.path = Some(path.to_owned());
        self
    }
}

impl fmt::Display for ImageError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.path {
            Some(path) => write!(formatter, "{}: {}", path.display(), self.cause),
            None => formatter.write_str(&self.cause),
        }
    }
}

impl std::error::Error for ImageError {}

impl From<FileError> for ImageError {
    fn from(error: FileError) -> ImageError {
        ImageError { path: Some(error.path), cause: error.cause }
    }
}
