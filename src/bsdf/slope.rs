//! Slopes of a Gaussian random surface, the two one-dimensional laws behind the Beckmann distribution (Heitz
//! and d'Eon 2014, "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals").
//!
//! Both quantile functions have no closed form. They are solved by Halley's method on complementary error
//! functions, which keep their digits in the tails, to rounding error.

use crate::math::function::{exp, ln};
use libm::erfc;
use std::f64::consts::PI;

/// √π
pub const SQRT_PI: f64 = 1.772_453_850_905_516;

/// Half the spacing of random numbers in [0, 1): what stands for 0, whose quantile would be infinite.
const SMALLEST: f64 = 1.0 / (1u64 << 54) as f64;

/// Beyond this slope lies less than [`SMALLEST`].
const EXTREME: f64 = 7.0;

/// The slope y below which a share `u` of the density exp(−y²)/√π lies.
pub fn gaussian(u: f64) -> f64 {
    // The upper half mirrors the lower one, where erfc has full relative precision.
    if u > 0.5 {
        return -gaussian(1.0 - u);
    }
    let mut y = gaussian_estimate(u);
    for _ in 0..2 {
        let step = (0.5 * erfc(-y) - u.max(SMALLEST)) * SQRT_PI * exp(y * y);
        y -= step / (1.0 + y * step);
    }
    y
}

/// [`gaussian`] to 0.2 %, by Winitzki's closed form (2008).
fn gaussian_estimate(u: f64) -> f64 {
    const A: f64 = 0.147;
    let l = ln(4.0 * u.max(SMALLEST) * (1.0 - u).max(SMALLEST));
    let b = 2.0 / (PI * A) + 0.5 * l;
    let y = ((b * b - l / A).sqrt() - b).max(0.0).sqrt();
    if u < 0.5 { -y } else { y }
}

/// The slope x below which a share `u` of the slopes lies that the direction (sin θ, 0, cos θ) sees.
///
/// A facet of slope x shows its projected area cos θ − x sin θ, so the visible density is proportional to
/// (cos θ − x sin θ)exp(−x²)/√π up to x = cot θ. Its integral is F(x) = ½ cos θ erfc(−x) + ½ sin θ
/// exp(−x²)/√π.
pub fn visible_gaussian(cos: f64, sin: f64, u: f64) -> f64 {
    let (mut low, mut high) = (-EXTREME, if sin * EXTREME > cos { cos / sin } else { EXTREME });
    let integral = |x: f64, bell: f64| 0.5 * (cos * erfc(-x) + sin * bell);
    let target = u.max(SMALLEST) * integral(high, exp(-high * high) / SQRT_PI);
    // Exact at normal incidence and, where the law is Rayleigh's, at grazing.
    let mut x = cos * gaussian_estimate(u) - sin * (-ln(u.max(SMALLEST))).sqrt();
    for _ in 0..64 {
        if !(x > low && x < high) {
            x = 0.5 * (low + high);
        }
        let bell = exp(-x * x) / SQRT_PI;
        let excess = integral(x, bell) - target;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let area = cos - x * sin;
        let step = excess / (area * bell);
        let next = x - step / (1.0 + step * (x + 0.5 * sin / area));
        // Steps shrink to their cubes, on the scale of the curvature: the next would be a rounding error.
        let last = (next - x).abs() * (area + sin) <= 1e-6 * area;
        x = next;
        if last {
            break;
        }
    }
    x.clamp(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use libm::erf;

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
