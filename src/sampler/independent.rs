//! Independent numbers: a PCG stream for every sample and block, so that nothing depends on what was drawn before.

use super::mix;
use rand_pcg::{Pcg32, rand_core::Rng};

pub fn block(key: u32, sample: u32, block: u32) -> [u32; 8] {
    let state = (key as u64) << 32 | mix(sample ^ key.rotate_left(16)) as u64;
    let stream = (mix(block.wrapping_mul(0x9e37_79b9) ^ key) as u64) << 32 | sample as u64;
    let mut generator = Pcg32::new(state, stream);
    std::array::from_fn(|_| generator.next_u32())
}
