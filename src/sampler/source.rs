//! Where the random numbers of a render come from.

use super::{SampleId, Sampler, SamplerKind};

/// Columns that stand for what belongs to no pixel: no film is so wide.
const LIGHT_PATHS: u32 = u32::MAX;
const PHOTONS: u32 = u32::MAX - 1;
const PLACES: u32 = u32::MAX - 2;

/// All random numbers of a render: a function of what they are for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomSource {
    pub kind: SamplerKind,
    pub seed: u32,
}

impl RandomSource {
    /// Those of a camera sample.
    pub fn camera(self, SampleId { pixel, sample }: SampleId) -> Sampler {
        Sampler::new(self.kind, self.seed, pixel, sample as u32)
    }

    /// Those of a light path that finds caustics, by its number over all samples.
    pub fn light_path(self, number: u64) -> Sampler {
        Sampler::new(self.kind, self.seed, (LIGHT_PATHS, (number >> 32) as u32), number as u32)
    }

    /// Those of a light path whose photons guide emitter samples.
    pub fn photon(self, number: u32) -> Sampler {
        Sampler::new(self.kind, self.seed, (PHOTONS, 0), number)
    }

    /// Those of the place that all samples of a number have within their pixels; see [`crate::render::spread`].
    pub fn place_in_pixels(self, sample: u64) -> Sampler {
        Sampler::new(self.kind, self.seed, (PLACES, 0), sample as u32)
    }
}
