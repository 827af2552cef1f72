//! Numerical integration of smooth functions, for constants that are computed once.

use super::function::cos;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Nodes and weights of the n-point Gauss–Legendre rule on [0, 1], n even: Newton's method on the recurrence
/// (k + 1)P₍ₖ₊₁₎ = (2k + 1)xPₖ − kP₍ₖ₋₁₎ from Tricomi's estimate of the roots.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut x = -cos(PI * (i as f64 + 0.75) / (n as f64 + 0.5));
        let mut slope = 0.0;
        for _ in 0..6 {
            let (mut before, mut value) = (1.0, x);
            for k in 1..n {
                let k = k as f64;
                (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
            }
            slope = n as f64 * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// ∫ₐᵇ f. The substitution x = a + (b − a)s² makes a square-root kink at `a`, as interfaces have at their
/// critical angle, a polynomial.
pub fn integrate_from_kink(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    const PANELS: usize = 8;
    static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(16));
    let panel = |i: usize| {
        let at = |&(node, weight): &(f64, f64)| {
            let s = (i as f64 + node) / PANELS as f64;
            weight * f(a + (b - a) * s * s) * 2.0 * s
        };
        RULE.iter().map(at).sum::<f64>()
    };
    (0..PANELS).map(panel).sum::<f64>() * (b - a) / PANELS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_integrates_polynomials() {
        for n in [2, 16, 32, 48] {
            for power in [0, 1, 2, 3] {
                let sum: f64 = gauss_legendre(n).iter().map(|(x, weight)| weight * x.powi(power)).sum();
                assert!((sum - 1.0 / (power + 1) as f64).abs() < 1e-14, "{n} {power} {sum}");
            }
        }
    }

    #[test]
    fn polynomials_and_square_roots_are_exact() {
        assert!((integrate_from_kink(1.0, 3.0, |x| x * x * x) - 20.0).abs() < 1e-12);
        assert!((integrate_from_kink(2.0, 6.0, |x| (x - 2.0).sqrt()) - 16.0 / 3.0).abs() < 1e-12);
    }
}
