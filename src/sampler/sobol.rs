//! Owen-scrambled Sobol points in padded pairs (Burley 2020, "Practical Hash-based Owen Scrambling").
//!
//! Every pair of dimensions is the (0,2)-sequence of the first two Sobol dimensions, with the order of its samples
//! shuffled and both coordinates scrambled by hashes of (seed, pixel, dimension). Any 2ᵏ consecutive samples that
//! start at a multiple of 2ᵏ are a net.

use super::mix;

/// Eight numbers of 32 bits: four pairs.
#[inline]
pub fn block(key: u32, sample: u32, block: u32) -> [u32; 8] {
    let key = mix(key ^ block.wrapping_mul(0x9e37_79b9));
    let seeds: [u32; 12] =
        std::array::from_fn(|i| mix(key.wrapping_add((i as u32).wrapping_mul(0x85eb_ca6b))));
    let reversed_index = sample.reverse_bits();
    let mut first = [0u32; 4];
    let mut second = [0u32; 4];
    for pair in 0..4 {
        // The index with its order shuffled, bits reversed: already the first Sobol coordinate.
        let x = scramble(reversed_index, seeds[pair]);
        first[pair] = scramble(x.reverse_bits(), seeds[4 + pair]).reverse_bits();
        second[pair] = scramble(second_dimension(x).reverse_bits(), seeds[8 + pair]).reverse_bits();
    }
    std::array::from_fn(|i| if i % 2 == 0 { first[i / 2] } else { second[i / 2] })
}

/// The second Sobol coordinate from the bit-reversed index: the Pascal matrix modulo 2, as five shifts.
#[inline]
fn second_dimension(mut x: u32) -> u32 {
    x ^= (x & 0x5555_5555) << 1;
    x ^= (x & 0x3333_3333) << 2;
    x ^= (x & 0x0f0f_0f0f) << 4;
    x ^= (x & 0x00ff_00ff) << 8;
    x ^ ((x & 0x0000_ffff) << 16)
}

/// Owen scrambling of a number whose bits are reversed: each bit flips by a hash of the bits below it
/// (Laine & Karras 2011, with the constants of pbrt-v4).
#[inline]
fn scramble(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

#[cfg(test)]
mod tests {
    use super::block;

    #[test]
    fn every_pair_of_every_aligned_block_of_samples_is_a_net() {
        for key in [1, 99] {
            for pair in 0..4 {
                for (start, log) in [(0u32, 4), (16, 4), (64, 6), (1 << 20, 8)] {
                    let points: Vec<(u32, u32)> = (start..start + (1 << log))
                        .map(|s| {
                            let b = block(key, s, 3);
                            (b[2 * pair], b[2 * pair + 1])
                        })
                        .collect();
                    for split in 0..=log {
                        // Elementary intervals of 2⁻ˢ × 2^(s − log) hold one point each.
                        let cell = |(x, y): &(u32, u32)| {
                            let high = |v: u32, bits: u32| if bits == 0 { 0 } else { v >> (32 - bits) };
                            (high(*x, split), high(*y, log - split))
                        };
                        let cells: std::collections::BTreeSet<_> = points.iter().map(cell).collect();
                        assert_eq!(cells.len(), points.len(), "pair {pair}, {start}+2^{log}, split {split}");
                    }
                }
            }
        }
    }
}
