//! Four `f64` at once: AVX registers where the build has them, an array where it has not.
//!
//! Both do the same IEEE operation to each lane, never a fused one, so they give the same bits; the tests
//! hold the intrinsics to the array. All `unsafe` of the renderer is here and in the folder of this name:
//! each call is of an intrinsic that the `cfg` above it guarantees, but for [`F64x4::lane`]. (The program has
//! one more, the allocator of `out_of_memory.rs`.)

mod floats;
mod lanewise;
mod prefetch;
mod words;

pub use floats::F32x8;
use lanewise::lanewise;
pub use prefetch::prefetch;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};
pub use words::U32x8;

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

/// Yes or no in each of four lanes.
#[derive(Clone, Copy, Debug)]
#[cfg(target_feature = "avx")]
pub struct Mask(__m256d);

/// Yes or no in each of four lanes.
#[derive(Clone, Copy, Debug)]
#[cfg(not(target_feature = "avx"))]
pub struct Mask([bool; 4]);

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

    /// Which lanes are at most the other's; none for NaN.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> Mask {
        Mask(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) })
    }

    /// Which lanes are below the other's; none for NaN.
    #[inline(always)]
    pub fn below(self, other: Self) -> Mask {
        Mask(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) })
    }

    /// Which lanes equal the other's; none for NaN.
    #[inline(always)]
    pub fn equals(self, other: Self) -> Mask {
        Mask(unsafe { _mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, other.0) })
    }

    /// Which lanes are negative, −0 included.
    #[inline(always)]
    pub fn negative(self) -> Mask {
        Mask(self.0)
    }
}

#[cfg(target_feature = "avx")]
impl Mask {
    /// A bit for each lane.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        unsafe { _mm256_movemask_pd(self.0) as u32 }
    }

    /// `yes` in the lanes of this mask, `no` in the others.
    #[inline(always)]
    pub fn select(self, yes: F64x4, no: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_blendv_pd(no.0, yes.0, self.0) })
    }

    /// The lanes of this mask that are not in the other.
    #[inline(always)]
    pub fn without(self, other: Self) -> Self {
        Self(unsafe { _mm256_andnot_pd(other.0, self.0) })
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

    /// Which lanes are at most the other's; none for NaN.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> Mask {
        Mask(std::array::from_fn(|i| self.0[i] <= other.0[i]))
    }

    /// Which lanes are below the other's; none for NaN.
    #[inline(always)]
    pub fn below(self, other: Self) -> Mask {
        Mask(std::array::from_fn(|i| self.0[i] < other.0[i]))
    }

    /// Which lanes equal the other's; none for NaN.
    #[inline(always)]
    pub fn equals(self, other: Self) -> Mask {
        Mask(std::array::from_fn(|i| self.0[i] == other.0[i]))
    }

    /// Which lanes are negative, −0 included.
    #[inline(always)]
    pub fn negative(self) -> Mask {
        Mask(self.0.map(f64::is_sign_negative))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

#[cfg(not(target_feature = "avx"))]
impl Mask {
    /// A bit for each lane.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        (0..4).fold(0, |bits, i| bits | u32::from(self.0[i]) << i)
    }

    /// `yes` in the lanes of this mask, `no` in the others.
    #[inline(always)]
    pub fn select(self, yes: F64x4, no: F64x4) -> F64x4 {
        F64x4(std::array::from_fn(|i| if self.0[i] { yes.0[i] } else { no.0[i] }))
    }

    /// The lanes of this mask that are not in the other.
    #[inline(always)]
    pub fn without(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] && !other.0[i]))
    }
}

impl F64x4 {
    /// The value of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> f64 {
        // SAFETY: a register in memory is its lanes in order, as the array is.
        let lanes: &[f64; 4] = unsafe { &*std::ptr::from_ref(self).cast() };
        lanes[lane]
    }

    /// The value of one lane, in all lanes.
    #[inline(always)]
    pub fn spread(&self, lane: usize) -> Self {
        Self::splat(self.lane(lane))
    }
}

lanewise! { F64x4, "avx":
    Add add _mm256_add_pd f64::add;
    Sub sub _mm256_sub_pd f64::sub;
    Mul mul _mm256_mul_pd f64::mul;
    Div div _mm256_div_pd f64::div;
}
lanewise! { Mask, "avx":
    BitAnd bitand _mm256_and_pd bool::bitand;
    BitOr bitor _mm256_or_pd bool::bitor;
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
                assert_eq!(x.at_most(y).bits(), u32::from(a <= b) * 5 + 2);
                assert_eq!(x.below(y).bits(), u32::from(a < b) * 5 + 2);
                assert_eq!(x.equals(y).bits(), u32::from(a == b) * 5);
                let (below, most) = (x.below(y), x.at_most(y));
                assert_eq!((below & most).bits(), below.bits());
                assert_eq!((below | most).bits(), most.bits());
                assert_eq!(most.without(below).bits(), u32::from(a == b) * 5);
                let chosen = if a.is_sign_negative() { b } else { a };
                assert_eq!(quiet(x.negative().select(y, x).to_array()[0]), quiet(chosen));
                assert_eq!(quiet(x.spread(2).to_array()[3]), quiet(a));
            }
        }
        assert_eq!(
            bits(F64x4::widen(&[0.1, 2.0, -3.0, 1e-40])),
            bits(F64x4::new([0.1f32 as f64, 2.0, -3.0, 1e-40f32 as f64]))
        );
        assert_eq!(bits(F64x4::new([-1.0; 4]).abs()), bits(F64x4::splat(1.0)));
    }
}
