//! Numbers in [0, 1), each a function of (seed, pixel, sample, dimension) and of nothing else.
//!
//! Numbers come in blocks of eight: block 0 belongs to the camera, one further block to every vertex of a
//! path; light paths of groups of pixels, guided and further emitter samples have ranges of their own beyond
//! ([`LIGHT_SOURCES`], [`GUIDED`]). Within a block the dimensions (0,1), (2,3), (4,5), (6,7) are pairs that a
//! sampler may stratify together.
//!
//! *How to add one*: write `sampler/<name>.rs` with a function that makes blocks; add a variant of [`Kind`]
//! and its rows in [`SAMPLERS`].

mod independent;
mod sobol;

use crate::math::DVec2;
use crate::math::simd::U32x8;
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::registry::Entry;
use rand_pcg::Pcg32;

/// What a sampler's element declares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerSettings {
    pub kind: Kind,
    pub samples: u32,
    pub seed: u32,
}

impl Default for SamplerSettings {
    fn default() -> Self {
        Self { kind: Kind::Sobol, samples: 4, seed: 0 }
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
pub enum Kind {
    Independent,
    Sobol,
}

macro_rules! samplers {
    ($($name:literal, $kind:ident, $about:literal;)*) => {
        /// Every sampler. Etalon's images equal Mitsuba's in expectation, never in noise, so Mitsuba's
        /// stratified samplers all mean the best stratification there is here.
        pub static SAMPLERS: &[Entry<SamplerSettings>] = &[$(Entry {
            name: $name,
            about: $about,
            examples: &[concat!(r#"<sampler type=""#, $name, r#""><integer name="sample_count" value="64"/></sampler>"#)],
            parse: |params| parse(params, Kind::$kind),
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

fn parse(params: &mut Params, kind: Kind) -> Result<SamplerSettings, SceneError> {
    let samples = params.integer("sample_count", 4, 1..=i64::from(u32::MAX), "samples a pixel")? as u32;
    let seed = params.integer("seed", 0, 0..=i64::from(u32::MAX), "another seed, another noise")? as u32;
    params.boolean("jitter", true, "Mitsuba's option of stratified samplers; ignored")?;
    params.integer("strength", 2, 0..=i64::from(u32::MAX), "Mitsuba's option of `orthogonal`; ignored")?;
    Ok(SamplerSettings { kind, samples, seed })
}

/// The numbers of one camera sample.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: Kind,
    /// Hash of the seed and the pixel.
    key: u32,
    sample: u32,
}

/// How many pairs of numbers a block has.
pub const PAIRS: usize = 4;

/// The block of the camera.
pub const CAMERA: u32 = 0;
/// The blocks of the vertices begin here.
pub const FIRST_VERTEX: u32 = 1;
/// Most vertices of a path.
pub const MOST_VERTICES: u32 = 1 << 20;
/// The blocks of light paths for groups of pixels begin here.
pub const LIGHT_SOURCES: u32 = 1 << 28;
/// The blocks of guided emitter samples begin here.
pub const GUIDED: u32 = 1 << 29;
/// Blocks of a guided emitter sample at each vertex.
pub const GUIDED_OF_VERTEX: u32 = 1 << 5;
/// The blocks of emitter samples begin here, where a vertex takes several: [`MOST_EMITTER_SAMPLES`] for each.
const EMITTER_SAMPLES: u32 = 1 << 30;
/// The blocks of flights through media begin here: for each edge of a path one for itself, and one for the
/// shadow ray of its end.
pub const FLIGHTS: u32 = 1 << 31;
/// How many emitter samples a vertex can take.
pub const MOST_EMITTER_SAMPLES: u32 = 1 << 10;

/// The column that stands for light paths that find caustics where samplers are given a pixel; no film is as
/// wide as this and the next two.
pub const CAUSTICS_COLUMN: u32 = u32::MAX;
/// The column of the light paths whose photons guide emitter samples.
pub const GUIDE_COLUMN: u32 = u32::MAX - 1;
/// The column of the place that all samples of a number have within their pixels; see
/// [`crate::render::spread`].
pub const PLACE_COLUMN: u32 = u32::MAX - 2;

// No two uses share a block.
const _: () = assert!(
    FIRST_VERTEX + MOST_VERTICES <= LIGHT_SOURCES
        && GUIDED + MOST_VERTICES * GUIDED_OF_VERTEX <= EMITTER_SAMPLES
        && MOST_VERTICES * MOST_EMITTER_SAMPLES <= EMITTER_SAMPLES
        && EMITTER_SAMPLES + (MOST_VERTICES * MOST_EMITTER_SAMPLES - 1) < FLIGHTS
);

/// The eight numbers of a block, as parts of 2³².
#[derive(Clone, Copy, Debug, Default)]
pub struct Numbers([u32; 8]);

impl Numbers {
    /// The number of a dimension, in [0, 1).
    #[inline(always)]
    pub fn one(&self, dimension: usize) -> f64 {
        f64::from(self.0[dimension]) * (1.0 / 4294967296.0)
    }

    /// The numbers of dimensions 2·`pair` and 2·`pair` + 1.
    #[inline(always)]
    pub fn pair(&self, pair: usize) -> DVec2 {
        DVec2::new(self.one(2 * pair), self.one(2 * pair + 1))
    }
}

impl Sampler {
    /// All pixels of a film of up to 2¹⁶ columns and rows have keys of their own: their low bits are one
    /// word, and what is done to it can be undone. The sum keeps the pixels of two seeds from sharing theirs
    /// by whole rows.
    pub fn new(kind: Kind, seed: u32, (x, y): (u32, u32), sample: u32) -> Self {
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
            (sampler, EMITTER_SAMPLES + depth * MOST_EMITTER_SAMPLES + beyond)
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

/// The numbers of a block for each of up to `N` samples, `N` a multiple of eight.
#[derive(Clone, Debug)]
pub struct ManyNumbers<const N: usize>([Numbers; N]);

impl<const N: usize> Default for ManyNumbers<N> {
    fn default() -> Self {
        Self([Numbers::default(); N])
    }
}

impl<const N: usize> ManyNumbers<N> {
    /// Fills the first `count` from the sampler and the block that `of` names for each, all samplers of one
    /// kind: eight at a time cost little more than one. Only the first so many pairs of each are made, for
    /// making them takes longer than anything that is done with them; the others are zero.
    #[inline]
    pub fn fill<'a>(&mut self, count: usize, pairs: usize, of: impl Fn(usize) -> (&'a Sampler, u32)) {
        for first in (0..count).step_by(8) {
            let (mut keys, mut samples, mut blocks) = ([0; 8], [0; 8], [0; 8]);
            let mut kind = Kind::Sobol;
            for i in 0..8.min(count - first) {
                let (sampler, block) = of(first + i);
                (keys[i], samples[i], blocks[i]) = (sampler.key, sampler.sample, block);
                kind = sampler.kind;
            }
            let words = [keys, samples, blocks].map(U32x8::new);
            let dimensions = match kind {
                Kind::Independent => independent::blocks(words[0], words[1], words[2], pairs),
                Kind::Sobol => sobol::blocks(words[0], words[1], words[2], pairs),
            };
            let samples = U32x8::transpose(dimensions).map(|words| Numbers(words.to_array()));
            self.0[first..first + 8].copy_from_slice(&samples);
        }
    }

    /// The numbers of sample `i`.
    #[inline(always)]
    pub fn of(&self, i: usize) -> &Numbers {
        &self.0[i]
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Kolmogorov–Smirnov distance from uniform, in units of 1/√n.
    fn distance(mut values: Vec<f64>) -> f64 {
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let gaps = values
            .iter()
            .enumerate()
            .map(|(i, v)| (v - i as f64 / n).abs().max((v - (i + 1) as f64 / n).abs()));
        gaps.fold(0.0, f64::max) * n.sqrt()
    }

    #[test]
    fn every_dimension_is_uniform_over_samples_and_over_pixels() {
        for kind in [Kind::Independent, Kind::Sobol] {
            for dimension in 0..8 {
                for block in [0, 1, 7] {
                    let value =
                        |pixel, sample| Sampler::new(kind, 1, pixel, sample).block(block).one(dimension);
                    // Exceeded once in 10⁷.
                    assert!(
                        distance((0..4096).map(|s| value((3, 5), s)).collect()) < 2.9,
                        "{kind:?} {dimension}"
                    );
                    assert!(
                        distance((0..4096).map(|p| value((p % 64, p / 64), 0)).collect()) < 2.9,
                        "{kind:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn dimensions_of_different_vertices_are_independent_within_a_pixel() {
        const CELLS: usize = 16;
        let samples = 1 << 16;
        for kind in [Kind::Independent, Kind::Sobol] {
            for (pixel, (one, other)) in
                (0..8).flat_map(|x| [(0, 1), (1, 2), (1, 9)].map(|blocks| ((x, 7), blocks)))
            {
                let mut counts = [[[0.0; CELLS]; CELLS]; 8];
                for sample in 0..samples {
                    let sampler = Sampler::new(kind, 0, pixel, sample);
                    let [a, b] = [one, other].map(|block| sampler.block(block));
                    for (dimension, counts) in counts.iter_mut().enumerate() {
                        let [i, j] = [a, b].map(|u| (u.one(dimension) * CELLS as f64) as usize);
                        counts[i][j] += 1.0;
                    }
                }
                let expected = f64::from(samples) / (CELLS * CELLS) as f64;
                for (dimension, counts) in counts.iter().enumerate() {
                    let of_cell = |count: &f64| (count - expected) * (count - expected) / expected;
                    let χ2: f64 = counts.as_flattened().iter().map(of_cell).sum();
                    // Of 255 degrees of freedom: exceeded once in 10⁷ by any of them.
                    assert!(χ2 < 430.0, "{kind:?} {pixel:?} {one} {other} {dimension}: {χ2}");
                }
            }
        }
    }

    #[test]
    fn emitter_samples_of_all_camera_samples_are_one_net() {
        for count in [2, 4] {
            let mut cells = std::collections::BTreeSet::new();
            for (sample, which) in (0..64 / count).flat_map(|sample| (0..count).map(move |i| (sample, i))) {
                let sampler = Sampler::new(Kind::Sobol, 1, (3, 5), sample);
                let p = sampler.emitter_samples(2, 0, count, 1).of(which as usize).pair(0) * 8.0;
                cells.insert((p.x as u32, p.y as u32));
            }
            assert_eq!(cells.len(), 64, "{count}");
        }
        // Nor does the sequence end where 32 bits do.
        let last = Sampler::new(Kind::Sobol, 1, (3, 5), u32::MAX);
        let first = Sampler::new(Kind::Sobol, 1, (3, 5), u32::MAX - 2);
        let numbers = |sampler: Sampler, which: u32| {
            sampler.emitter_samples(0, which / 8 * 8, 1024, PAIRS).of(which as usize % 8).0
        };
        assert_ne!(numbers(last, 0), numbers(first, 0));
        let at = |sample| Sampler::new(Kind::Sobol, 1, (3, 5), sample);
        assert_ne!(numbers(at(0), 7), numbers(at(1 << 22), 7));
        // Those that are made together are those that are made alone, however many pairs of them.
        for which in 0..8 {
            let (together, alone) =
                (at(9).emitter_samples(3, 0, 11, 1), at(9).emitter_samples(3, which, 11, PAIRS));
            assert_eq!(together.of(which as usize).pair(0), alone.of(0).pair(0));
        }
    }

    #[test]
    fn seeds_pixels_and_samples_do_not_share_numbers() {
        let all = |kind| {
            let mut seen = std::collections::BTreeSet::new();
            for (seed, x, y, sample) in [(0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]
            {
                let block = Sampler::new(kind, seed, (x, y), sample).block(3);
                seen.extend(block.0);
            }
            seen.len()
        };
        assert_eq!((all(Kind::Independent), all(Kind::Sobol)), (40, 40));
    }

    #[test]
    fn no_two_pixels_of_a_large_film_are_alike() {
        for seed in 0..3 {
            let key = |i: u32| Sampler::new(Kind::Sobol, seed, (i % 3840, i / 3840), 0).key;
            let mut keys: Vec<u32> = (0..3840 * 2160).map(key).collect();
            keys.sort_unstable();
            keys.dedup();
            assert_eq!(keys.len(), 3840 * 2160, "{seed}");
        }
    }

    /// Keys have 32 bits, so some pixels of two images of this size share theirs, but no rows of them.
    #[test]
    fn pixels_of_two_seeds_are_alike_here_and_there() {
        let size = 1u32 << 10;
        let keys = |seed| {
            let key = move |i: u32| (Sampler::new(Kind::Sobol, seed, (i % size, i / size), 0).key, i);
            (0..size * size).map(key).collect::<std::collections::BTreeMap<_, _>>()
        };
        let all: Vec<_> = (0..4).map(keys).collect();
        for (a, b) in [(0, 1), (0, 2), (1, 2), (2, 3)] {
            let shared = all[a].keys().filter(|key| all[b].contains_key(*key)).count();
            // 256 are expected; so far from it once in 10⁹.
            assert!((160..=352).contains(&shared), "{a} {b}: {shared}");
        }
    }
}
