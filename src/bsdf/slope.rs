//! Slopes of a Gaussian random surface, the two one-dimensional laws behind the Beckmann distribution (Heitz
//! and d'Eon 2014, "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals").
//!
//! The second has a quantile without a closed form. It is solved by Householder's method to rounding error,
//! with a complementary error function that keeps its digits in the tails.

use crate::math::BELOW_ONE;
use crate::math::function::{exp, ln};
use crate::math::gaussian::{erfcx, normal_quantile};
use std::f64::consts::FRAC_1_SQRT_2;

/// √π
pub const SQRT_PI: f64 = 1.772_453_850_905_516;

/// Half the spacing of random numbers in [0, 1): what stands for 0, whose quantile would be infinite.
const SMALLEST: f64 = 1.0 / (1u64 << 54) as f64;

/// Beyond this slope lies less than [`SMALLEST`].
const EXTREME: f64 = 7.0;

/// The slope y below which a share `u` of the density exp(−y²)/√π lies.
#[inline]
pub fn gaussian(u: f64) -> f64 {
    FRAC_1_SQRT_2 * normal_quantile(u.clamp(SMALLEST, BELOW_ONE))
}

/// The slope x below which a share `u` of the slopes lies that the direction (sin θ, 0, cos θ) sees.
///
/// A facet of slope x shows its projected area A(x) = cos θ − x sin θ, so the visible density is proportional to
/// f(x) = A(x)exp(−x²)/√π up to x = cot θ. Its integral is F(x) = ½ cos θ erfc(−x) + ½ sin θ exp(−x²)/√π.
///
/// With the step of Newton's method s = (F − target)/f and the derivatives f′/f = −2x − sin θ/A and f″/f = 4x²
/// − 2 + 4x sin θ/A, Householder's third method (1970) has the error's fourth power as its next error.
pub fn visible_gaussian(cos: f64, sin: f64, u: f64) -> f64 {
    let (mut low, mut high) = (-EXTREME, if sin * EXTREME > cos { cos / sin } else { EXTREME });
    let bell = |x: f64| exp(-x * x) / SQRT_PI;
    let integral = |x: f64, bell: f64| 0.5 * (cos * share(x, bell) + sin * bell);
    let target = u.max(SMALLEST) * integral(high, bell(high));
    // Exact at normal incidence and, where the law is Rayleigh's, at grazing.
    let mut x = cos * gaussian(u) - sin * (-ln(u.max(SMALLEST))).sqrt();
    for _ in 0..64 {
        if !(x > low && x < high) {
            x = 0.5 * (low + high);
        }
        let bell = bell(x);
        let excess = integral(x, bell) - target;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let area = cos - x * sin;
        let turn = x * (sin / area);
        let newton = excess / (area * bell);
        let first = -2.0 * x - sin / area;
        let second = 4.0 * (x * x + turn) - 2.0;
        let next = x - newton * (1.0 - 0.5 * newton * first)
            / (1.0 - newton * first + newton * newton * second / 6.0);
        // Steps shrink to their fourth powers, on the scale of the curvature: the next would be a rounding error.
        let last = (next - x).abs() * (area + sin) <= 1e-4 * area;
        x = next;
        if last {
            break;
        }
    }
    x.clamp(low, high)
}

/// erfc(−x), twice the share of a Gaussian below x, from exp(−x²)/√π.
#[inline]
fn share(x: f64, bell: f64) -> f64 {
    let beyond = SQRT_PI * bell * erfcx(x.abs());
    if x < 0.0 { beyond } else { 2.0 - beyond }
}

#[cfg(test)]
mod tests {
    use super::*;
    use libm::{erf, erfc};

    #[test]
    fn quantiles_invert_the_distribution() {
        for i in 0..=2000 {
            let u = i as f64 / 2000.0;
            let y = gaussian(u);
            assert!((0.5 * erfc(-y) - u).abs() < 4e-16, "{u} {y}");
            for j in 0..=40 {
                let θ = (j as f64 / 40.0 * 89.9999f64).to_radians();
                let (sin, cos) = libm::sincos(θ);
                let x = visible_gaussian(cos, sin, u);
                let integral = |x: f64| 0.5 * (cos * (1.0 + erf(x)) + sin * exp(-x * x) / SQRT_PI);
                let whole = integral((cos / sin).min(20.0));
                assert!((integral(x) / whole - u).abs() < 4e-15, "{u} {θ} {x}");
                assert!(x * sin <= cos * (1.0 + 1e-15));
            }
        }
    }

    #[test]
    fn tails_keep_their_digits() {
        for exponent in 1..54 {
            let u = 0.5f64.powi(exponent);
            assert!((0.5 * erfc(-gaussian(u)) / u - 1.0).abs() < 1e-13, "{exponent}");
            let x = visible_gaussian(0.6, 0.8, u);
            let integral = |x: f64| 0.5 * (0.6 * erfc(-x) + 0.8 * exp(-x * x) / SQRT_PI);
            assert!((integral(x) / integral(0.75) / u - 1.0).abs() < 1e-13, "{exponent}");
        }
        assert!(gaussian(0.0) > -EXTREME && visible_gaussian(0.0, 1.0, 0.0) > -EXTREME);
    }
}
