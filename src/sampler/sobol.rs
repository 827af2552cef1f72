//! Owen-scrambled Sobol points in padded pairs (Burley 2020, "Practical Hash-based Owen Scrambling").
//!
//! Every pair of dimensions is the (0,2)-sequence of the first two Sobol dimensions, with the order of its
//! samples shuffled and both coordinates scrambled by hashes of (seed, pixel, dimension). Any 2ᵏ consecutive
//! samples that start at a multiple of 2ᵏ are a net.

use super::mix;
use crate::math::simd::U32x8;

/// The first `pairs` pairs of 32-bit numbers of eight samples; the rest stays zero.
#[inline]
pub fn blocks(keys: U32x8, samples: U32x8, blocks: U32x8, pairs: usize) -> [U32x8; 8] {
    let key = mix(keys ^ (blocks * U32x8::splat(0x9e37_79b9)));
    let seed = |i: u32| mix(key + U32x8::splat(i.wrapping_mul(0x85eb_ca6b)));
    let reversed_index = samples.reverse_bits();
    let mut numbers = [U32x8::splat(0); 8];
    for pair in 0..4 {
        if pair as usize >= pairs {
            break;
        }
        // The index with its order shuffled, bits reversed: already the first Sobol coordinate.
        let x = scramble(reversed_index, seed(pair));
        let (first, second) = (x.reverse_bits(), second_dimension(x).reverse_bits());
        let at = 2 * pair as usize;
        numbers[at] = scramble(first, seed(4 + pair)).reverse_bits();
        numbers[at + 1] = scramble(second, seed(8 + pair)).reverse_bits();
    }
    numbers
}

/// The second Sobol coordinate from the bit-reversed index: the Pascal matrix modulo 2, as five shifts.
#[inline(always)]
fn second_dimension(mut x: U32x8) -> U32x8 {
    x = x ^ (x & U32x8::splat(0x5555_5555)).left::<1>();
    x = x ^ (x & U32x8::splat(0x3333_3333)).left::<2>();
    x = x ^ (x & U32x8::splat(0x0f0f_0f0f)).left::<4>();
    x = x ^ (x & U32x8::splat(0x00ff_00ff)).left::<8>();
    x ^ x.left::<16>()
}

/// Owen scrambling of numbers whose bits are reversed: each bit flips by a hash of the bits below it
/// (Laine & Karras 2011, with the constants of pbrt-v4).
#[inline(always)]
fn scramble(mut x: U32x8, seed: U32x8) -> U32x8 {
    x = x ^ (x * U32x8::splat(0x3d20_adea));
    x = x + seed;
    x = x * (seed.right::<16>() | U32x8::splat(1));
    x = x ^ (x * U32x8::splat(0x0552_6c56));
    x ^ (x * U32x8::splat(0x53a2_2864))
}

#[cfg(test)]
mod tests {
    use super::blocks;
    use crate::math::simd::U32x8;

    #[test]
    fn every_pair_of_every_aligned_block_of_samples_is_a_net() {
        for key in 0..2 {
            for pair in 0..4 {
                for (start, log) in [(0u32, 4), (16, 4), (64, 6), (1 << 20, 8)] {
                    let points: Vec<(u32, u32)> = (start..start + (1 << log))
                        .map(|s| {
                            let b = blocks(U32x8::splat(key), U32x8::splat(s), U32x8::splat(3), 4);
                            (b[2 * pair].to_array()[0], b[2 * pair + 1].to_array()[0])
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

    /// Numbers of dimension `d`, of 2³² parts, of samples 0 to `count`.
    fn numbers(key: u32, d: usize, count: u32) -> Vec<u32> {
        let number = |s| blocks(U32x8::splat(key), U32x8::splat(s), U32x8::splat(3), 4)[d].to_array()[0];
        (0..count).map(number).collect()
    }

    #[test]
    fn dimensions_of_different_pairs_have_nothing_to_do_with_each_other() {
        let dimensions: Vec<Vec<u32>> = (0..8).map(|d| numbers(7, d, 4096)).collect();
        for a in 0..8 {
            for b in 0..a {
                let cells = dimensions[a].iter().zip(&dimensions[b]).map(|(x, y)| (x >> 29, y >> 29));
                // Of 64 cells with 64 points each none is empty but once in 10²⁶.
                assert_eq!(cells.collect::<std::collections::BTreeSet<_>>().len(), 64, "{a} {b}");
            }
        }
    }

    /// Four points with one in every row, column and quarter of a square of sixteen cells: each column of the
    /// left half decides for a quarter, and so does one of the right, and in both halves of the rows one of
    /// two orders is left, 2⁴ patterns in all. Scrambling makes all of them, unless it does to one axis what
    /// it does to the other.
    #[test]
    fn the_axes_of_a_pair_are_scrambled_independently() {
        for pair in 0..4 {
            let pattern = |key| {
                let (x, y) = (numbers(key, 2 * pair, 4), numbers(key, 2 * pair + 1, 4));
                let cells = x.into_iter().zip(y).map(|(x, y)| (x >> 30, y >> 30));
                cells.collect::<std::collections::BTreeSet<_>>()
            };
            let patterns: std::collections::BTreeSet<_> = (0..1000).map(pattern).collect();
            assert_eq!(patterns.len(), 16, "pair {pair}");
        }
    }
}
