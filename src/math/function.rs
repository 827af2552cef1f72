//! Transcendental functions that give the same bits on every machine.
//!
//! The C libraries of two systems differ in up to a tenth of all arguments. Where speed does not matter these are
//! the functions of the `libm` crate; the two that every path needs several times, [`sin_cos_turn`] and [`ln`]
//! over lanes, are polynomials.

pub use libm::{acos, asin, atan, atan2, cos, cosh, exp, log as ln, pow, sin, sincos, sinh, tan, tanh};

/// sin(2πu) and cos(2πu) for u in [0, 1], to 2e-15.
///
/// The argument is folded to an eighth of a turn, where the Taylor polynomials in (2πu)² have converged;
/// working in turns makes the folding exact.
#[inline(always)]
pub fn sin_cos_turn(u: f64) -> (f64, f64) {
    let quarter = (4.0 * u + 0.5).floor();
    let x = (u - 0.25 * quarter) * std::f64::consts::TAU;
    let x2 = x * x;
    let sin = x
        * (1.0
            + x2 * (-1.0 / 6.0
                + x2 * (1.0 / 120.0
                    + x2 * (-1.0 / 5040.0
                        + x2 * (1.0 / 362880.0
                            + x2 * (-1.0 / 39916800.0
                                + x2 * (1.0 / 6227020800.0 + x2 * (-1.0 / 1307674368000.0))))))));
    let cos = 1.0
        + x2 * (-0.5
            + x2 * (1.0 / 24.0
                + x2 * (-1.0 / 720.0
                    + x2 * (1.0 / 40320.0
                        + x2 * (-1.0 / 3628800.0
                            + x2 * (1.0 / 479001600.0 + x2 * (-1.0 / 87178291200.0)))))));
    match quarter as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Natural logarithm of eight positive normal numbers, to 3e-7 relative to the larger of 1 and |ln x|.
///
/// x = 2ᵏ·m with m in [√½, √2); ln m = 2·artanh((m − 1)/(m + 1)), an odd series that converges fast because
/// |(m − 1)/(m + 1)| ≤ 0.172. Written over lanes so that it fills one vector register.
#[inline(always)]
pub fn ln_lanes(x: [f32; 8]) -> [f32; 8] {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let mut logarithms = [0.0; 8];
    for (logarithm, x) in logarithms.iter_mut().zip(x) {
        let bits = x.to_bits().wrapping_sub(SQRT_HALF_BITS);
        let exponent = (bits as i32) >> 23;
        let mantissa = f32::from_bits((bits & 0x007f_ffff).wrapping_add(SQRT_HALF_BITS));
        let z = (mantissa - 1.0) / (mantissa + 1.0);
        let z2 = z * z;
        let series =
            2.0 * z * (1.0 + z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0 + z2 * (1.0 / 9.0)))));
        *logarithm = exponent as f32 * std::f32::consts::LN_2 + series;
    }
    logarithms
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_turn_meets_libm_everywhere() {
        for i in 0..=4096 {
            let u = i as f64 / 4096.0;
            let (s, c) = sin_cos_turn(u);
            assert!((s - sin(u * std::f64::consts::TAU)).abs() < 2e-15, "sin at {u}");
            assert!((c - cos(u * std::f64::consts::TAU)).abs() < 2e-15, "cos at {u}");
        }
    }

    #[test]
    fn ln_lanes_meets_libm_over_the_whole_range() {
        for exponent in -120..120 {
            for step in 0..8 {
                let x = libm::ldexpf(1.0 + step as f32 / 8.0, exponent);
                let (got, expected) = (ln_lanes([x; 8])[3] as f64, ln(x as f64));
                assert!((got - expected).abs() <= 3e-7 * expected.abs().max(1.0), "{x}: {got} {expected}");
            }
        }
    }
}
