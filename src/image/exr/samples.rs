//! How the crate `exr` takes a channel's values from where they are, without a copy of the image.

use crate::film::Accumulators;
use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::Header;

/// The values of a channel of the file, taken from where they are.
#[derive(Clone, Copy)]
pub(super) enum Samples<'a> {
    /// Floats, pixel by pixel in rows.
    Values(&'a [f32]),
    /// One word of the stored form of one channel's accumulators.
    Word { accumulators: &'a Accumulators, channel: usize, word: usize },
}

impl Samples<'_> {
    /// Number of pixels.
    pub(super) fn len(&self) -> usize {
        match self {
            Samples::Values(values) => values.len(),
            Samples::Word { accumulators, .. } => {
                accumulators.width() as usize * accumulators.height() as usize
            }
        }
    }
}

impl<'a> WritableSamples<'a> for Samples<'_> {
    type Writer = Rows<'a>;

    fn sample_type(&self) -> SampleType {
        match self {
            Samples::Values(_) => SampleType::F32,
            Samples::Word { .. } => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'a self, header: &Header) -> Rows<'a> {
        Rows { samples: *self, size: header.layer_size }
    }
}

/// A channel that is being written into the file.
pub(super) struct Rows<'a> {
    samples: Samples<'a>,
    size: Vec2<usize>,
}

impl SamplesWriter for Rows<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let Vec2(x, y) = line.location.position;
        let first = y * self.size.width() + x;
        let written = match self.samples {
            Samples::Values(values) => line.write_samples(|i| values[first + i]),
            Samples::Word { accumulators, channel, word } => {
                line.write_samples(|i| accumulators.pixel((x + i) as u32, y as u32)[channel].word(word))
            }
        };
        written.expect("a line of the header's width holds its samples");
    }
}
