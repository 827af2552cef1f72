//! Transcendental functions that give the same bits on every machine.
//!
//! The C libraries of two systems differ in up to a tenth of all arguments. Where speed does not matter these
//! are the functions of the `libm` crate; the one that every path needs several times, [`sin_cos_turn`], is a
//! pair of polynomials.

use super::INV_PI;
pub use libm::{
    asin, atan, atan2, cbrt, cos, cosh, exp, expm1, log as ln, pow, sin, sincos, sinh, tan, tanh,
};

/// The arc cosine, as twice the angle whose tangent is √((1 − x)/(1 + x)). `libm`'s own holds an SSE root, at
/// which the processor waits for its AVX registers; see [`length`](super::length).
pub fn acos(x: f64) -> f64 {
    2.0 * atan2((1.0 - x).sqrt(), (1.0 + x).sqrt())
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
    fn sin_cos_turn_meets_libm_everywhere() {
        for i in 0..=4096 {
            let u = i as f64 / 4096.0;
            let (s, c) = sin_cos_turn(u);
            assert!((s - sin(u * std::f64::consts::TAU)).abs() < 2e-15, "sin at {u}");
            assert!((c - cos(u * std::f64::consts::TAU)).abs() < 2e-15, "cos at {u}");
        }
    }
}
