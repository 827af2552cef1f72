//! Four `f64` at once: AVX registers where the build has them, an array of four where it has not.
//!
//! Both do the same IEEE operation to each lane, never a fused one, so they give the same bits; the tests hold the
//! intrinsics to the array. All `unsafe` of the program is in this file: each call is of an intrinsic that the
//! `cfg` above it guarantees.

use std::ops::{Add, Div, Mul, Neg, Sub};

#[cfg(target_feature = "avx")]
use std::arch::x86_64::*;

/// Four lanes.
#[derive(Clone, Copy, Debug)]
#[cfg(target_feature = "avx")]
pub struct F64x4(__m256d);

/// Four lanes.
#[derive(Clone, Copy, Debug)]
#[cfg(not(target_feature = "avx"))]
#[repr(align(32))]
pub struct F64x4([f64; 4]);

#[cfg(target_feature = "avx")]
impl F64x4 {
    #[inline(always)]
    pub fn new(v: [f64; 4]) -> Self {
        Self(unsafe { _mm256_loadu_pd(v.as_ptr()) })
    }

    #[inline(always)]
    pub fn splat(v: f64) -> Self {
        Self(unsafe { _mm256_set1_pd(v) })
    }

    /// Four `f32`, widened exactly.
    #[inline(always)]
    pub fn widen(v: &[f32; 4]) -> Self {
        Self(unsafe { _mm256_cvtps_pd(_mm_loadu_ps(v.as_ptr())) })
    }

    #[inline(always)]
    pub fn to_array(self) -> [f64; 4] {
        let mut array = [0.0; 4];
        unsafe { _mm256_storeu_pd(array.as_mut_ptr(), self.0) };
        array
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    /// `if self < other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    /// `if self > other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    /// A bit for each lane that is at most the other's; none for NaN.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> u32 {
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
    }

    /// A bit for each lane that is below the other's; none for NaN.
    #[inline(always)]
    pub fn below(self, other: Self) -> u32 {
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0)) as u32 }
    }

    /// `yes` where this lane is negative (−0 included), else `no`.
    #[inline(always)]
    pub fn negative_select(self, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, self.0) })
    }
}

#[cfg(not(target_feature = "avx"))]
impl F64x4 {
    #[inline(always)]
    pub fn new(v: [f64; 4]) -> Self {
        Self(v)
    }

    #[inline(always)]
    pub fn splat(v: f64) -> Self {
        Self([v; 4])
    }

    /// Four `f32`, widened exactly.
    #[inline(always)]
    pub fn widen(v: &[f32; 4]) -> Self {
        Self(v.map(f64::from))
    }

    #[inline(always)]
    pub fn to_array(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    /// `if self < other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    /// `if self > other { self } else { other }` in each lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// A bit for each lane that is at most the other's; none for NaN.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> u32 {
        (0..4).fold(0, |bits, i| bits | u32::from(self.0[i] <= other.0[i]) << i)
    }

    /// A bit for each lane that is below the other's; none for NaN.
    #[inline(always)]
    pub fn below(self, other: Self) -> u32 {
        (0..4).fold(0, |bits, i| bits | u32::from(self.0[i] < other.0[i]) << i)
    }

    /// `yes` where this lane is negative (−0 included), else `no`.
    #[inline(always)]
    pub fn negative_select(self, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if self.0[i].is_sign_negative() { yes.0[i] } else { no.0[i] }))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

macro_rules! operators {
    ($($Trait:ident $method:ident $intrinsic:ident $operator:tt;)*) => {$(
        impl $Trait for F64x4 {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                #[cfg(target_feature = "avx")]
                return Self(unsafe { $intrinsic(self.0, other.0) });
                #[cfg(not(target_feature = "avx"))]
                return self.zip(other, |a, b| a $operator b);
            }
        }
    )*};
}
operators! {
    Add add _mm256_add_pd +;
    Sub sub _mm256_sub_pd -;
    Mul mul _mm256_mul_pd *;
    Div div _mm256_div_pd /;
}

impl Neg for F64x4 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self * Self::splat(-1.0)
    }
}

/// The scalar product of two vectors of lanes.
#[inline(always)]
pub fn dot(a: [F64x4; 3], b: [F64x4; 3]) -> F64x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_do_what_scalars_do() {
        let samples = [0.0, -0.0, 1.0, -3.5, 1e300, 5e-324, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.1];
        let bits = |v: F64x4| v.to_array().map(f64::to_bits);
        let quiet = |v: f64| if v.is_nan() { None } else { Some(v.to_bits()) };
        for &a in &samples {
            for &b in &samples {
                let (x, y) = (F64x4::new([a, 1.0, a, 2.0]), F64x4::new([b, 4.0, b, 0.5]));
                let cases =
                    [(x + y, a + b), (x - y, a - b), (x * y, a * b), (x / y, a / b), (x.sqrt(), a.sqrt())];
                for (lanes, scalar) in cases {
                    assert_eq!(quiet(lanes.to_array()[2]), quiet(scalar), "{a} {b}");
                }
                assert_eq!(quiet(x.min(y).to_array()[0]), quiet(if a < b { a } else { b }));
                assert_eq!(quiet(x.max(y).to_array()[0]), quiet(if a > b { a } else { b }));
                assert_eq!(x.at_most(y), u32::from(a <= b) * 5 + 2);
                assert_eq!(x.below(y), u32::from(a < b) * 5 + 2);
                let chosen = if a.is_sign_negative() { b } else { a };
                assert_eq!(quiet(x.negative_select(y, x).to_array()[0]), quiet(chosen));
            }
        }
        assert_eq!(
            bits(F64x4::widen(&[0.1, 2.0, -3.0, 1e-40])),
            bits(F64x4::new([0.1f32 as f64, 2.0, -3.0, 1e-40f32 as f64]))
        );
        assert_eq!(bits(F64x4::new([-1.0; 4]).abs()), bits(F64x4::splat(1.0)));
    }
}
