//! Independent numbers: a PCG stream for every sample and block, so that nothing depends on what was drawn
//! before.

use super::mix;
use crate::math::simd::U32x8;
use rand_pcg::{Pcg32, rand_core::Rng};

/// The streams of eight samples.
///
/// The generator is linear in where it begins and in its stream: two streams that differed by the same for all
/// samples would go on to do so, and their numbers would depend on each other. So the block as well as the
/// sample is hashed into where it begins.
fn generators(keys: U32x8, samples: U32x8, blocks: U32x8) -> [Pcg32; 8] {
    let of_sample = mix(samples ^ (keys.left::<16>() | keys.right::<16>()));
    let low = mix(of_sample + blocks * U32x8::splat(0x85eb_ca6b)).to_array();
    let high = mix((blocks * U32x8::splat(0x9e37_79b9)) ^ keys).to_array();
    let (keys, samples) = (keys.to_array(), samples.to_array());
    let word = |high: u32, low: u32| u64::from(high) << 32 | u64::from(low);
    std::array::from_fn(|i| Pcg32::new(word(keys[i], low[i]), word(high[i], samples[i])))
}

/// The stream of one sample.
pub fn generator(key: u32, sample: u32, block: u32) -> Pcg32 {
    let [first, ..] = generators(U32x8::splat(key), U32x8::splat(sample), U32x8::splat(block));
    first
}

/// The first `pairs` pairs of 32-bit numbers of eight samples; the rest stays zero.
pub fn blocks(keys: U32x8, samples: U32x8, blocks: U32x8, pairs: usize) -> [U32x8; 8] {
    let mut generators = generators(keys, samples, blocks);
    let mut numbers = [U32x8::splat(0); 8];
    for number in &mut numbers[..2 * pairs] {
        *number = U32x8::new(std::array::from_fn(|i| generators[i].next_u32()));
    }
    numbers
}
