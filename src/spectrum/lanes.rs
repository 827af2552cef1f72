//! The eight values a path carries.

use std::ops::{Add, AddAssign, Mul, MulAssign};

/// Wavelengths a path carries at once; eight `f32` fill one AVX2 register.
pub const LANES: usize = 8;

/// One value for each of the path's wavelengths; units are those of the quantity.
///
/// In RGB mode the lanes are R, G, B and five zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Spectrum(pub [f32; LANES]);

impl Spectrum {
    pub const ZERO: Self = Self([0.0; LANES]);
    pub const ONE: Self = Self([1.0; LANES]);

    #[inline(always)]
    pub const fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    // Plain loops: the array functions of the standard library are not always turned into vector code.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
        let mut lanes = [0.0; LANES];
        for (i, lane) in lanes.iter_mut().enumerate() {
            *lane = f(i);
        }
        Self(lanes)
    }

    #[inline(always)]
    pub fn map(self, mut f: impl FnMut(f32) -> f32) -> Self {
        Self::from_fn(|i| f(self.0[i]))
    }

    /// Combines two spectra lane by lane.
    #[inline(always)]
    pub fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self::from_fn(|i| f(self.0[i], other.0[i]))
    }

    /// The sum over lanes, as a balanced tree: a fixed order that vector units do fast.
    #[inline(always)]
    pub fn sum(self) -> f32 {
        let v = self.0;
        let a: [f32; 4] = std::array::from_fn(|i| v[i] + v[i + 4]);
        (a[0] + a[2]) + (a[1] + a[3])
    }

    #[inline(always)]
    pub fn max(self) -> f32 {
        self.0.iter().fold(f32::NEG_INFINITY, |a, &b| if b > a { b } else { a })
    }

    /// exp of numbers up to 0, to a few units of the last place; numbers below −87 count as −∞.
    ///
    /// With n = x/ln 2, rounded, exp x = 2ⁿ exp(x − n ln 2), and the Taylor polynomial has converged for what
    /// is left, of at most ln 2/2. ln 2 is subtracted in two pieces, of which the first times n is exact.
    #[inline]
    pub fn exp(self) -> Self {
        const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
        // Added to a number, it leaves its nearest integer in the last bits.
        const ROUND: f32 = 12_582_912.0;
        self.map(|x| {
            let finite = x.max(-87.0);
            let n = (finite * std::f32::consts::LOG2_E + ROUND) - ROUND;
            let r = (finite - n * LN_2[0]) - n * LN_2[1];
            let tail = 1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0)));
            let exp = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * tail)));
            let scale = f32::from_bits(((n as i32 + 127) << 23) as u32);
            if x < -87.0 { 0.0 } else { exp * scale }
        })
    }

    #[inline(always)]
    pub fn is_zero(self) -> bool {
        // Without the sign, one test of all bits.
        self.0.iter().fold(0, |bits, v| bits | v.to_bits() << 1) == 0
    }

    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|v| v.is_finite())
    }
}

impl Mul for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<f32> for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        self.map(|a| a * factor)
    }
}

impl MulAssign for Spectrum {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl MulAssign<f32> for Spectrum {
    #[inline(always)]
    fn mul_assign(&mut self, factor: f32) {
        *self = *self * factor;
    }
}

impl Add for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl AddAssign for Spectrum {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_meets_libm() {
        for i in 0..=87 * 64 {
            let x = -(i as f32) / 64.0;
            let (found, expected) = (Spectrum::splat(x).exp().0[3], libm::exp(f64::from(x)));
            assert!((f64::from(found) / expected - 1.0).abs() < 4e-7, "{x}: {found} {expected}");
        }
        let special = Spectrum([0.0, -0.0, -1e-30, -87.5, -1e30, f32::NEG_INFINITY, -1e-6, -88.0]).exp();
        assert_eq!(special.0, [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.999_999, 0.0]);
    }
}
