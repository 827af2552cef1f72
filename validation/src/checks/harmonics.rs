//! Real spherical harmonics: orthonormal functions on the sphere, sorted by how fast they vary.

use crate::scatterer::DVec3;

/// The `N` = (degree + 1)² harmonics Y_lm of a unit direction, at index l(l + 1) + m.
///
/// Associated Legendre functions divided by sin^m θ, by the usual three-term recurrence in l; cos mφ sin^m θ
/// and sin mφ sin^m θ are the parts of (x + iy)^m, so nothing is divided by sin θ.
pub(super) fn harmonics<const N: usize>(w: DVec3) -> [f64; N] {
    let mut values = [0.0; N];
    let degree = (1..).take_while(|l| l * l < N).count();
    // N(m, m) P(m, m) / sin^m θ, and (x + iy)^m.
    let (mut sectoral, mut power) = ((0.25 * std::f64::consts::FRAC_1_PI).sqrt(), [1.0, 0.0]);
    for m in 0..=degree {
        let (mut before, mut current) = (0.0, sectoral);
        for l in m..=degree {
            let base = l * (l + 1);
            if m == 0 {
                values[base] = current;
            } else {
                let scaled = std::f64::consts::SQRT_2 * current;
                (values[base + m], values[base - m]) = (scaled * power[0], scaled * power[1]);
            }
            let next = factor(l + 1, m) * (w.z * current - before / factor(l, m));
            (before, current) = (current, next);
        }
        sectoral *= -((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
        power = [power[0] * w.x - power[1] * w.y, power[0] * w.y + power[1] * w.x];
    }
    values
}

/// √((4l² − 1)/(l² − m²)); infinite for l = m, where the recurrence starts.
fn factor(l: usize, m: usize) -> f64 {
    if l == m {
        return f64::INFINITY;
    }
    ((4 * l * l - 1) as f64 / (l * l - m * m) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        quadrature::{Cell, integrate},
        scatterer::direction,
    };
    use std::f64::consts::PI;

    #[test]
    fn harmonics_are_orthonormal() {
        let sphere = Cell { low: [-1.0, -PI], high: [1.0, PI] };
        let at = |i: usize| move |[z, phi]: [f64; 2]| harmonics::<81>(direction(z, phi))[i];
        for (i, j) in [(0, 0), (0, 2), (1, 1), (2, 2), (3, 3), (5, 5), (7, 7), (5, 7), (10, 26), (26, 26)] {
            let (a, b) = (at(i), at(j));
            let found = integrate(&[sphere], 1e-9, 400_000, |point| a(point) * b(point)).value;
            assert!((found - f64::from(i == j)).abs() < 1e-7, "{i} {j}: {found}");
        }
    }

    #[test]
    fn the_sum_of_squares_is_the_same_everywhere() {
        // Unsöld's theorem: Σ Y² = N / 4π, which every one of the 81 must be right for.
        for w in [direction(0.3, 1.0), direction(-0.99, -2.0), DVec3::Z, direction(0.0, 3.0)] {
            let sum: f64 = harmonics::<81>(w).iter().map(|y| y * y).sum();
            assert!((sum * 4.0 * PI / 81.0 - 1.0).abs() < 1e-12, "{sum}");
        }
    }
}
