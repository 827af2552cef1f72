//! Eight `f32` at once: an AVX register where the build has them, an array where it has not.

use super::lanewise::lanewise;
use std::ops::{Mul, Sub};

#[cfg(target_feature = "avx")]
use std::arch::x86_64::*;

/// Eight lanes.
#[derive(Clone, Copy, Debug)]
#[cfg(target_feature = "avx")]
pub struct F32x8(__m256);

/// Eight lanes.
#[derive(Clone, Copy, Debug)]
#[cfg(not(target_feature = "avx"))]
pub struct F32x8([f32; 8]);

#[cfg(target_feature = "avx")]
impl F32x8 {
    #[inline(always)]
    pub fn new(v: &[f32; 8]) -> Self {
        Self(unsafe { _mm256_loadu_ps(v.as_ptr()) })
    }

    #[inline(always)]
    pub fn splat(v: f32) -> Self {
        Self(unsafe { _mm256_set1_ps(v) })
    }

    #[inline(always)]
    pub fn to_array(self) -> [f32; 8] {
        let mut array = [0.0; 8];
        unsafe { _mm256_storeu_ps(array.as_mut_ptr(), self.0) };
        array
    }

    /// `if self < other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    /// `if self > other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    /// A bit for each lane that is at most the other's; none for NaN.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> u32 {
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
    }
}

#[cfg(not(target_feature = "avx"))]
impl F32x8 {
    #[inline(always)]
    pub fn new(v: &[f32; 8]) -> Self {
        Self(*v)
    }

    #[inline(always)]
    pub fn splat(v: f32) -> Self {
        Self([v; 8])
    }

    #[inline(always)]
    pub fn to_array(self) -> [f32; 8] {
        self.0
    }

    /// `if self < other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }

    /// `if self > other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }

    /// A bit for each lane that is at most the other's; none for NaN.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> u32 {
        (0..8).fold(0, |bits, i| bits | u32::from(self.0[i] <= other.0[i]) << i)
    }
}

lanewise! { F32x8, "avx":
    Sub sub _mm256_sub_ps f32::sub;
    Mul mul _mm256_mul_ps f32::mul;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_do_what_scalars_do() {
        let samples = [0.0f32, -0.0, 1.5, -3.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-40];
        let quiet = |v: f32| if v.is_nan() { None } else { Some(v.to_bits()) };
        for shift in 0..8 {
            let other: [f32; 8] = std::array::from_fn(|i| samples[(i + shift) % 8]);
            let (x, y) = (F32x8::new(&samples), F32x8::new(&other));
            for i in 0..8 {
                let (a, b) = (samples[i], other[i]);
                assert_eq!(quiet((x - y).to_array()[i]), quiet(a - b), "{a} {b}");
                assert_eq!(quiet((x * y).to_array()[i]), quiet(a * b), "{a} {b}");
                assert_eq!(quiet(x.min(y).to_array()[i]), quiet(if a < b { a } else { b }), "{a} {b}");
                assert_eq!(quiet(x.max(y).to_array()[i]), quiet(if a > b { a } else { b }), "{a} {b}");
                assert_eq!(x.at_most(y) >> i & 1 == 1, a <= b, "{a} {b}");
                assert_eq!(quiet(F32x8::splat(a).to_array()[i]), quiet(a));
            }
        }
    }
}
