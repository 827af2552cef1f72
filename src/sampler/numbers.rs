//! The eight numbers of a block, and what each is for.

use super::{Sampler, SamplerKind, independent, sobol};
use crate::math::DVec2;
use crate::math::simd::U32x8;

/// How many pairs of numbers a block has.
pub const PAIRS: usize = 4;

/// The eight numbers of a block, as parts of 2³², and what each is for:
///
/// | | camera | emitter of a light path | vertex of a camera path | vertex of a light path |
/// |--:|---|---|---|---|
/// | 0, 1 | place on the film | place on the emitter | place on an emitter | place on the lens |
/// | 2, 3 | 2: wavelengths | direction | direction | direction |
/// | 4 | lens | wavelengths | further digits for the emitter | pixel |
/// | 5 | lens | further digits for the emitter | lobe; 2 where none has a density | lobe |
/// | 6 | | which object the direction is aimed at | Russian roulette | Russian roulette |
/// | 7 | | | link, or flight through a medium | pixel |
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

    #[cfg(test)]
    pub(super) fn words(&self) -> [u32; 8] {
        self.0
    }
}

/// What chooses an emitter and the place on it.
#[derive(Clone, Copy, Debug)]
pub struct EmitterNumbers {
    /// The first of the two chooses the emitter as well, and what is left of it is the place.
    pub place: DVec2,
    /// Further digits for the choice; see [`Discrete::sample_strip`](crate::math::Discrete::sample_strip).
    pub digits: f64,
}

/// The camera's.
impl Numbers {
    #[inline(always)]
    pub fn place_on_film(&self) -> DVec2 {
        self.pair(0)
    }

    #[inline(always)]
    pub fn wavelengths(&self) -> f64 {
        self.one(2)
    }

    #[inline(always)]
    pub fn place_on_lens(&self) -> DVec2 {
        self.pair(2)
    }
}

/// Those of a light path's beginning.
impl Numbers {
    #[inline(always)]
    pub fn emission(&self) -> EmitterNumbers {
        EmitterNumbers { place: self.pair(0), digits: self.one(5) }
    }

    /// The direction, and what chooses the object that it is aimed at.
    #[inline(always)]
    pub fn aim(&self) -> (DVec2, f64) {
        (self.pair(1), self.one(6))
    }

    #[inline(always)]
    pub fn light_wavelengths(&self) -> f64 {
        self.one(4)
    }
}

/// Those of a vertex.
impl Numbers {
    #[inline(always)]
    pub fn emitter_sample(&self) -> EmitterNumbers {
        EmitterNumbers { place: self.pair(0), digits: self.one(4) }
    }

    /// What chooses a lobe, and its direction.
    #[inline(always)]
    pub fn scattering(&self) -> (f64, DVec2) {
        self.scattering_if(true)
    }

    /// The same where a lobe has a density or, `has_density` being false, none has. Then no direction is drawn: its
    /// first number, better spread, chooses the lobe.
    #[inline(always)]
    pub fn scattering_if(&self, has_density: bool) -> (f64, DVec2) {
        (if has_density { self.lobe() } else { self.one(2) }, self.pair(1))
    }

    #[inline(always)]
    pub fn lobe(&self) -> f64 {
        self.one(5)
    }

    #[inline(always)]
    pub fn roulette(&self) -> f64 {
        self.one(6)
    }

    #[inline(always)]
    pub fn link(&self) -> f64 {
        self.one(7)
    }

    #[inline(always)]
    pub fn flight(&self) -> f64 {
        self.one(7)
    }

    /// The place on the lens that a light path's vertex is connected to.
    #[inline(always)]
    pub fn connection(&self) -> DVec2 {
        self.pair(0)
    }

    /// What chooses one of the pixels whose filters reach the place where it is seen.
    #[inline(always)]
    pub fn pixel(&self) -> DVec2 {
        DVec2::new(self.one(4), self.one(7))
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
            let mut kind = SamplerKind::Sobol;
            for i in 0..8.min(count - first) {
                let (sampler, block) = of(first + i);
                (keys[i], samples[i], blocks[i]) = (sampler.key, sampler.sample, block);
                kind = sampler.kind;
            }
            let words = [keys, samples, blocks].map(U32x8::new);
            let dimensions = match kind {
                SamplerKind::Independent => independent::blocks(words[0], words[1], words[2], pairs),
                SamplerKind::Sobol => sobol::blocks(words[0], words[1], words[2], pairs),
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
