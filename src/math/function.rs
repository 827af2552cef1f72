//! Transcendental functions that give the same bits on every machine.
//!
//! The C libraries of two systems differ in up to a tenth of all arguments. Where speed does not matter these
//! are the functions of the `libm` crate; those that paths need several times, [`sin_cos_turn`] and [`exp`], are
//! polynomials.

use super::INV_PI;
pub use libm::{
    asin, atan, atan2, cbrt, cos, cosh, expm1, hypot, ilogb, log as ln, pow, scalbn, sin, sincos, sinh, tan,
    tanh,
};

/// The arc cosine, as twice the angle whose tangent is √((1 − x)/(1 + x)). `libm`'s own holds an SSE root, at
/// which the processor waits for its AVX registers; see [`length`](super::length).
pub fn acos(x: f64) -> f64 {
    2.0 * atan2((1.0 - x).sqrt(), (1.0 + x).sqrt())
}

/// exp x, within 1.5 units of the last place.
///
/// With n = x/ln 2, rounded, exp x = 2ⁿ exp(x − n ln 2), and the Taylor polynomial has converged for what is
/// left, of at most ln 2/2. ln 2 is subtracted in two pieces, of which the first times n is exact. The terms are
/// added in pairs and pairs of pairs, which do not wait for each other.
#[inline]
pub fn exp(x: f64) -> f64 {
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    // Added to a number, it leaves its nearest integer in the last bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // Beyond, the result may not be a normal number.
    if x.is_nan() || x.abs() > 700.0 {
        return libm::exp(x);
    }
    let n = (x * std::f64::consts::LOG2_E + ROUND) - ROUND;
    let r = (x - n * LN_2[0]) - n * LN_2[1];
    let (r2, r4) = (r * r, (r * r) * (r * r));
    let pair = |c: f64, d: f64| c + r * d;
    let low = pair(0.5, 1.0 / 6.0) + r2 * pair(1.0 / 24.0, 1.0 / 120.0);
    let middle = pair(1.0 / 720.0, 1.0 / 5040.0) + r2 * pair(1.0 / 40320.0, 1.0 / 362880.0);
    let high = pair(1.0 / 3628800.0, 1.0 / 39916800.0) + r2 * pair(1.0 / 479001600.0, 1.0 / 6227020800.0);
    let exp = 1.0 + (r + r2 * (low + r4 * (middle + r4 * high)));
    exp * f64::from_bits(((n as i64 + 1023) << 52) as u64)
}

/// sin(2πu) and cos(2πu) for |u| ≤ 1/8, where the Taylor polynomials in (2πu)² have converged.
#[inline(always)]
pub fn sin_cos_eighth(u: f64) -> (f64, f64) {
    let x = u * std::f64::consts::TAU;
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
    (sin, cos)
}

/// sin(2πu) and cos(2πu) for u in [0, 1], to 2e-15.
///
/// The argument is folded to an eighth of a turn; working in turns makes the folding exact.
#[inline(always)]
pub fn sin_cos_turn(u: f64) -> (f64, f64) {
    let quarter = (4.0 * u + 0.5).floor();
    let (sin, cos) = sin_cos_eighth(u - 0.25 * quarter);
    match quarter as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The angle of (x, y) from the x axis as a part of a turn, from 0 to 1.
#[inline]
pub fn turn(y: f64, x: f64) -> f64 {
    let turn = 0.5 * INV_PI * atan2(y, x);
    if turn < 0.0 { turn + 1.0 } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acos_meets_libm() {
        for i in -4096..=4096 {
            let x = i as f64 / 4096.0;
            assert!((acos(x) - libm::acos(x)).abs() < 1e-15, "{x}");
        }
    }

    #[test]
    fn exp_meets_libm() {
        for i in -80_000..=80_000 {
            let x = f64::from(i) * 0.01 + f64::from(i % 7) * 1e-3;
            let (ours, theirs) = (exp(x), libm::exp(x));
            assert!(ours == theirs || (ours / theirs - 1.0).abs() < 5e-16, "{x} {ours} {theirs}");
        }
        assert_eq!(exp(0.0), 1.0);
        assert_eq!((exp(f64::NEG_INFINITY), exp(f64::INFINITY)), (0.0, f64::INFINITY));
        assert!(exp(f64::NAN).is_nan());
    }

    #[test]
    fn sin_cos_turn_meets_libm_everywhere() {
        for i in 0..=4096 {
            let u = i as f64 / 4096.0;
            let (s, c) = sin_cos_turn(u);
            assert!((s - sin(u * std::f64::consts::TAU)).abs() < 2e-15, "sin at {u}");
            assert!((c - cos(u * std::f64::consts::TAU)).abs() < 2e-15, "cos at {u}");
        }
    }
}
