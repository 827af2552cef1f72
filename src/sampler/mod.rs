//! Numbers in [0, 1), each a function of (seed, pixel, sample, dimension) and of nothing else.
//!
//! Numbers come in blocks of eight: block 0 belongs to the camera, one further block to every vertex of a
//! path, and further ones to what else needs numbers ([`blocks`]). Within a block, each number has its use
//! ([`Numbers`]); the dimensions (0,1), (2,3), (4,5), (6,7) are pairs that a sampler may stratify together.
//!
//! *How to add one*: write `sampler/<name>.rs` with a function that makes blocks; add a variant of [`SamplerKind`]
//! and its rows in [`SAMPLERS`].

pub mod blocks;
mod independent;
mod numbers;
mod sobol;
mod source;
#[cfg(test)]
mod tests;

use crate::math::simd::U32x8;
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::registry::Entry;
pub use numbers::{EmitterNumbers, ManyNumbers, Numbers, PAIRS};
use rand_pcg::Pcg32;
pub use source::RandomSource;

/// What a sampler's element declares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerSettings {
    pub kind: SamplerKind,
    pub samples: u32,
    pub seed: u32,
}

impl Default for SamplerSettings {
    fn default() -> Self {
        Self { kind: SamplerKind::Sobol, samples: 4, seed: 0 }
    }
}

/// Which camera sample: what its numbers, and so its light, are a function of beside the seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleId {
    /// Column and row on the film.
    pub pixel: (u32, u32),
    pub sample: u64,
}

/// How numbers are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SamplerKind {
    Independent,
    Sobol,
}

impl SamplerKind {
    /// Whether samples know of each other, so that their mean is better than that of as many independent ones.
    pub fn stratifies(self) -> bool {
        self != Self::Independent
    }
}

macro_rules! samplers {
    ($($name:literal, $kind:ident, $about:literal;)*) => {
        /// Every sampler. Etalon's images equal Mitsuba's in expectation, never in noise, so Mitsuba's
        /// stratified samplers all mean the best stratification there is here.
        pub static SAMPLERS: &[Entry<SamplerSettings>] = &[$(Entry {
            name: $name,
            about: $about,
            examples: &[concat!(r#"<sampler type=""#, $name, r#""><integer name="sample_count" value="64"/></sampler>"#)],
            parse: |params| parse(params, SamplerKind::$kind),
        }),*];
    };
}
samplers! {
    "independent", Independent, "Independent uniform numbers (PCG).";
    "sobol", Sobol, "Owen-scrambled Sobol pairs; the default.";
    "stratified", Sobol, "Accepted for Mitsuba's sake; the same as `sobol`.";
    "multijitter", Sobol, "Accepted for Mitsuba's sake; the same as `sobol`.";
    "orthogonal", Sobol, "Accepted for Mitsuba's sake; the same as `sobol`.";
    "ldsampler", Sobol, "Accepted for Mitsuba's sake; the same as `sobol`.";
}

fn parse(params: &mut Params, kind: SamplerKind) -> Result<SamplerSettings, SceneError> {
    let samples = params.count("sample_count", 4, 1..=u32::MAX, "samples a pixel")?;
    let seed = params.count("seed", 0, 0..=u32::MAX, "another seed, another noise")?;
    params.boolean("jitter", true, "Mitsuba's option of stratified samplers; ignored")?;
    params.count("strength", 2, 0..=u32::MAX, "Mitsuba's option of `orthogonal`; ignored")?;
    Ok(SamplerSettings { kind, samples, seed })
}

/// The numbers of one path: that of a camera sample, a light path, or a photon.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    /// Hash of the seed and the pixel.
    key: u32,
    sample: u32,
}

impl Sampler {
    /// All pixels of a film of up to 2¹⁶ columns and rows have keys of their own: their low bits are one
    /// word, and what is done to it can be undone. The sum keeps the pixels of two seeds from sharing theirs
    /// by whole rows.
    pub fn new(kind: SamplerKind, seed: u32, (x, y): (u32, u32), sample: u32) -> Self {
        let word = U32x8::splat;
        let of_seed = mix(word(seed ^ 0x9e37_79b9));
        let high = mix(of_seed ^ word(x >> 16 | y & 0xffff_0000));
        let key = mix(mix(of_seed ^ word(x & 0xffff | y << 16)) + high);
        Self { kind, key: key.to_array()[0], sample }
    }

    /// The numbers of another sample of the same pixel.
    #[inline]
    pub fn at(self, sample: u32) -> Self {
        Self { sample, ..self }
    }

    /// The numbers of up to eight of `count` emitter samples at a vertex with `depth` vertices before it,
    /// from the one with number `first` on, and so many pairs of each. Those of all camera samples are one
    /// sequence, better spread than `count` of their own.
    #[inline]
    pub fn emitter_samples(&self, depth: u32, first: u32, count: u32, pairs: usize) -> ManyNumbers<8> {
        let samplers: [_; 8] = std::array::from_fn(|i| self.one_of(first + i as u32, count));
        let mut numbers = ManyNumbers::default();
        numbers.fill((count - first).min(8) as usize, pairs, |i| {
            let (sampler, beyond) = &samplers[i];
            (sampler, blocks::emitter_sample(depth, *beyond))
        });
        numbers
    }

    /// The numbers of `count` emitter samples at a vertex, one after the other; see
    /// [`Sampler::emitter_samples`].
    pub fn each_emitter_sample(&self, depth: u32, count: u32, pairs: usize) -> impl Iterator<Item = Numbers> {
        (0..count).step_by(8).flat_map(move |first| {
            let some = self.emitter_samples(depth, first, count, pairs);
            (0..(count - first).min(8) as usize).map(move |i| *some.of(i))
        })
    }

    /// One of `count` samplers that stand for this sample, those of all samples being one sequence, and the
    /// overflow of its number above 32 bits.
    #[inline]
    pub fn one_of(&self, which: u32, count: u32) -> (Self, u32) {
        let number = u64::from(self.sample) * u64::from(count) + u64::from(which);
        (self.at(number as u32), (number >> 32) as u32)
    }

    /// As many independent numbers as are wanted, of one block.
    pub fn generator(&self, block: u32) -> Pcg32 {
        independent::generator(self.key, self.sample, block)
    }

    /// The numbers of one block.
    #[inline]
    pub fn block(&self, block: u32) -> Numbers {
        let mut many = ManyNumbers::<8>::default();
        many.fill(1, PAIRS, |_| (self, block));
        *many.of(0)
    }
}

/// A hash of 32 bits whose every output bit depends on every input bit (Wellons' lowbias32).
#[inline(always)]
fn mix(mut x: U32x8) -> U32x8 {
    x = x ^ x.right::<16>();
    x = x * U32x8::splat(0x7feb_352d);
    x = x ^ x.right::<15>();
    x = x * U32x8::splat(0x846c_a68b);
    x ^ x.right::<16>()
}
