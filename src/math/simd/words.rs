//! Eight `u32` at once: an AVX2 register where the build has them, an array where it has not.

use super::lanewise::lanewise;
use std::ops::{Add, BitAnd, BitOr, BitXor, Mul};

#[cfg(target_feature = "avx2")]
use std::arch::x86_64::*;

/// Eight 32-bit words, with arithmetic modulo 2³².
#[derive(Clone, Copy, Debug)]
#[cfg(target_feature = "avx2")]
pub struct U32x8(__m256i);

/// Eight 32-bit words, with arithmetic modulo 2³².
#[derive(Clone, Copy, Debug)]
#[cfg(not(target_feature = "avx2"))]
pub struct U32x8([u32; 8]);

#[cfg(target_feature = "avx2")]
impl U32x8 {
    #[inline(always)]
    pub fn new(v: [u32; 8]) -> Self {
        Self(unsafe { _mm256_loadu_si256(v.as_ptr().cast()) })
    }

    #[inline(always)]
    pub fn splat(v: u32) -> Self {
        Self(unsafe { _mm256_set1_epi32(v as i32) })
    }

    #[inline(always)]
    pub fn to_array(self) -> [u32; 8] {
        let mut array = [0; 8];
        unsafe { _mm256_storeu_si256(array.as_mut_ptr().cast(), self.0) };
        array
    }

    #[inline(always)]
    pub fn left<const N: i32>(self) -> Self {
        Self(unsafe { _mm256_slli_epi32::<N>(self.0) })
    }

    #[inline(always)]
    pub fn right<const N: i32>(self) -> Self {
        Self(unsafe { _mm256_srli_epi32::<N>(self.0) })
    }

    /// The words whose bits are set, the last first, and after them anything.
    #[inline(always)]
    pub fn backwards(self, which: u8) -> Self {
        unsafe {
            let order = _mm_loadl_epi64(ORDERS[usize::from(which)].as_ptr().cast());
            Self(_mm256_permutevar8x32_epi32(self.0, _mm256_cvtepu8_epi32(order)))
        }
    }

    /// Word j of vector i becomes word i of vector j: first within pairs of words, then of pairs, then of
    /// halves.
    #[inline(always)]
    pub fn transpose(rows: [Self; 8]) -> [Self; 8] {
        unsafe {
            let words = |i: usize, j: usize| {
                let (a, b) = (rows[i].0, rows[j].0);
                [_mm256_unpacklo_epi32(a, b), _mm256_unpackhi_epi32(a, b)]
            };
            let [low, high] = [0, 4].map(|i| [words(i, i + 1), words(i + 2, i + 3)]);
            let pairs = |[a, b]: [[__m256i; 2]; 2], i: usize| {
                [_mm256_unpacklo_epi64(a[i], b[i]), _mm256_unpackhi_epi64(a[i], b[i])]
            };
            std::array::from_fn(|j| {
                let (a, b) = (pairs(low, j / 2 % 2)[j % 2], pairs(high, j / 2 % 2)[j % 2]);
                Self(if j < 4 {
                    _mm256_permute2x128_si256::<0x20>(a, b)
                } else {
                    _mm256_permute2x128_si256::<0x31>(a, b)
                })
            })
        }
    }

    /// Each word with its 32 bits in opposite order: nibbles by two tables, then the bytes of each word.
    #[inline(always)]
    pub fn reverse_bits(self) -> Self {
        unsafe {
            let low = _mm256_set1_epi8(0x0f);
            let reversed = _mm256_broadcastsi128_si256(_mm_setr_epi8(
                0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15,
            ));
            let to_low = _mm256_shuffle_epi8(reversed, _mm256_and_si256(_mm256_srli_epi32::<4>(self.0), low));
            let to_high = _mm256_shuffle_epi8(reversed, _mm256_and_si256(self.0, low));
            let bytes = _mm256_or_si256(to_low, _mm256_slli_epi32::<4>(to_high));
            let swap = _mm256_broadcastsi128_si256(_mm_setr_epi8(
                3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12,
            ));
            Self(_mm256_shuffle_epi8(bytes, swap))
        }
    }
}

#[cfg(not(target_feature = "avx2"))]
impl U32x8 {
    #[inline(always)]
    pub fn new(v: [u32; 8]) -> Self {
        Self(v)
    }

    #[inline(always)]
    pub fn splat(v: u32) -> Self {
        Self([v; 8])
    }

    #[inline(always)]
    pub fn to_array(self) -> [u32; 8] {
        self.0
    }

    #[inline(always)]
    pub fn left<const N: i32>(self) -> Self {
        Self(self.0.map(|v| v << N))
    }

    #[inline(always)]
    pub fn right<const N: i32>(self) -> Self {
        Self(self.0.map(|v| v >> N))
    }

    /// The words whose bits are set, the last first, and after them anything.
    #[inline(always)]
    pub fn backwards(self, which: u8) -> Self {
        Self(ORDERS[usize::from(which)].map(|word| self.0[usize::from(word)]))
    }

    /// Word j of vector i becomes word i of vector j.
    #[inline(always)]
    pub fn transpose(rows: [Self; 8]) -> [Self; 8] {
        std::array::from_fn(|j| Self(rows.map(|row| row.0[j])))
    }

    /// Each word with its 32 bits in opposite order.
    #[inline(always)]
    pub fn reverse_bits(self) -> Self {
        Self(self.0.map(u32::reverse_bits))
    }
}

/// For each set of bits, their indices, the last first.
static ORDERS: [[u8; 8]; 256] = {
    let mut orders = [[0; 8]; 256];
    let mut which = 0;
    while which < 256 {
        let (mut bit, mut at) = (8, 0);
        while bit > 0 {
            bit -= 1;
            if which >> bit & 1 == 1 {
                orders[which][at] = bit as u8;
                at += 1;
            }
        }
        which += 1;
    }
    orders
};

lanewise! { U32x8, "avx2":
    Add add _mm256_add_epi32 u32::wrapping_add;
    Mul mul _mm256_mullo_epi32 u32::wrapping_mul;
    BitAnd bitand _mm256_and_si256 u32::bitand;
    BitOr bitor _mm256_or_si256 u32::bitor;
    BitXor bitxor _mm256_xor_si256 u32::bitxor;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_do_what_scalars_do() {
        let samples = [0u32, 1, 0x8000_0000, u32::MAX, 0x1234_5678, 0x9e37_79b9, 0x0f0f_1234, 77];
        for shift in 0..8 {
            let other: [u32; 8] = std::array::from_fn(|i| samples[(i + shift) % 8]);
            let (x, y) = (U32x8::new(samples), U32x8::new(other));
            let each =
                |f: fn(u32, u32) -> u32| -> [u32; 8] { std::array::from_fn(|i| f(samples[i], other[i])) };
            assert_eq!((x + y).to_array(), each(u32::wrapping_add));
            assert_eq!((x * y).to_array(), each(u32::wrapping_mul));
            assert_eq!((x & y).to_array(), each(|a, b| a & b));
            assert_eq!((x | y).to_array(), each(|a, b| a | b));
            assert_eq!((x ^ y).to_array(), each(|a, b| a ^ b));
            assert_eq!(y.left::<7>().to_array(), other.map(|v| v << 7));
            assert_eq!(y.right::<16>().to_array(), other.map(|v| v >> 16));
            assert_eq!(y.reverse_bits().to_array(), other.map(u32::reverse_bits));
            assert_eq!(U32x8::splat(other[0]).to_array(), [other[0]; 8]);
        }
        for which in 0..=u8::MAX {
            let picked = U32x8::new(samples).backwards(which).to_array();
            let expected: Vec<u32> =
                (0..8).rev().filter(|bit| which >> bit & 1 == 1).map(|bit| samples[bit]).collect();
            assert_eq!(picked[..expected.len()], expected);
        }
        let rows: [[u32; 8]; 8] = std::array::from_fn(|i| std::array::from_fn(|j| (8 * i + j) as u32));
        let columns = U32x8::transpose(rows.map(U32x8::new)).map(U32x8::to_array);
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            assert_eq!(columns[j][i], rows[i][j]);
        }
    }
}
