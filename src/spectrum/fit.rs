//! Fitting a sigmoid reflectance to a colour (Jakob & Hanika 2019, section 4).
//!
//! The polynomial is fitted in s = (λ − 360)/470, where its three coefficients are of like size.

use super::observer::{self, WAVELENGTH_MAX, WAVELENGTH_MIN};
use crate::math::function::cbrt;
use glam::{DMat3, DVec3};
use std::sync::LazyLock;

/// Simpson's 3/8 rule with three intervals to one of the observer's table: 283 points and one of weight 0
/// that fills the last vector of four.
const POINTS: usize = 284;
const LANES: usize = 4;

/// The observer under D65, in linear sRGB.
struct Response {
    s: [f64; POINTS],
    rgb: [[f64; POINTS]; 3],
    /// XYZ of a reflectance of 1.
    white: DVec3,
}

static RESPONSE: LazyLock<Response> = LazyLock::new(|| {
    let last = POINTS - 2;
    let s = std::array::from_fn(|i| i as f64 / last as f64);
    let weighted = std::array::from_fn::<DVec3, POINTS, _>(|i| {
        let λ = (WAVELENGTH_MIN as f64 + (WAVELENGTH_MAX - WAVELENGTH_MIN) as f64 * s[i]) as f32;
        let simpson = match i {
            _ if i > last => 0.0,
            _ if i == 0 || i == last => 1.0,
            _ if i % 3 == 0 => 2.0,
            _ => 3.0,
        };
        DVec3::from(observer::xyz(λ).map(f64::from)) * (simpson * observer::d65(λ) as f64)
    });
    let sum: DVec3 = weighted.iter().sum();
    let mut response = Response { s, rgb: [[0.0; POINTS]; 3], white: sum / sum.y };
    for (i, point) in weighted.iter().enumerate() {
        for (channel, value) in observer::xyz_to_rgb((*point / sum.y).to_array()).into_iter().enumerate() {
            response.rgb[channel][i] = value;
        }
    }
    response
});

/// The linear sRGB colour of a reflectance under D65, and its derivative by the coefficients (a column for
/// each).
fn color(c: DVec3) -> (DVec3, DMat3) {
    let response = &*RESPONSE;
    // Four running sums of each quantity: a fixed order of addition that fills a vector register.
    let mut sums = [[[0.0; LANES]; 4]; 3];
    for start in (0..POINTS).step_by(LANES) {
        for lane in 0..LANES {
            let s = response.s[start + lane];
            let x = (c.x * s + c.y) * s + c.z;
            let inverse = 1.0 / (1.0 + x * x).sqrt();
            let value = 0.5 * x * inverse + 0.5;
            let slope = 0.5 * (inverse * inverse * inverse);
            for (channel, sum) in sums.iter_mut().enumerate() {
                let weight = response.rgb[channel][start + lane];
                let sloped = weight * slope;
                sum[0][lane] += weight * value;
                sum[1][lane] += sloped * (s * s);
                sum[2][lane] += sloped * s;
                sum[3][lane] += sloped;
            }
        }
    }
    let [value, by_x, by_y, by_z] = [0, 1, 2, 3]
        .map(|quantity| DVec3::from([0, 1, 2].map(|channel| sums[channel][quantity].iter().sum())));
    (value, DMat3::from_cols(by_x, by_y, by_z))
}

/// CIELAB of linear sRGB relative to D65, and its derivative by R, G and B.
fn lab(rgb: DVec3) -> (DVec3, DMat3) {
    const DELTA: f64 = 6.0 / 29.0;
    let to_xyz = DMat3::from_cols_array_2d(&observer::RGB_TO_XYZ).transpose();
    let relative = DMat3::from_diagonal(RESPONSE.white.recip()) * to_xyz;
    let (mut f, mut slope) = (DVec3::ZERO, DVec3::ZERO);
    for (i, t) in (relative * rgb).to_array().into_iter().enumerate() {
        if t > DELTA * DELTA * DELTA {
            f[i] = cbrt(t);
            slope[i] = 1.0 / (3.0 * f[i] * f[i]);
        } else {
            slope[i] = 1.0 / (3.0 * DELTA * DELTA);
            f[i] = t * slope[i] + 4.0 / 29.0;
        }
    }
    // L* = 116 f(Y) − 16, a* = 500 (f(X) − f(Y)), b* = 200 (f(Y) − f(Z)).
    let mix = DMat3::from_cols(
        DVec3::new(0.0, 500.0, 0.0),
        DVec3::new(116.0, -500.0, 200.0),
        DVec3::new(0.0, 0.0, -200.0),
    );
    (mix * f - DVec3::new(16.0, 0.0, 0.0), mix * DMat3::from_diagonal(slope) * relative)
}

/// Damped Gauss–Newton in CIELAB, from coefficients `c` towards those of the colour `rgb`.
///
/// The damping decides only near black and white, where coefficients would run away for less than an eye can
/// see; it and the number of steps are such that the result is that of the tables that Mitsuba reads: the
/// coefficients of both differ by 1e-4 in the median and by some 2 % at the very ends.
pub fn gauss_newton(rgb: DVec3, mut c: DVec3) -> DVec3 {
    const STEPS: usize = 10;
    const DAMPING: f64 = 4e-7;
    const SQUARED_ERROR: f64 = 1e-6;
    let target = lab(rgb).0;
    for _ in 0..STEPS {
        let (value, value_by_c) = color(c);
        let (lab, lab_by_value) = lab(value);
        let error = target - lab;
        if error.length_squared() < SQUARED_ERROR {
            break;
        }
        let jacobian = lab_by_value * value_by_c;
        let normal = jacobian.transpose() * jacobian + DMat3::from_diagonal(DVec3::splat(DAMPING));
        c += normal.inverse() * (jacobian.transpose() * error);
    }
    c
}

/// The coefficients of the same polynomial in λ in nm.
///
/// With s = (λ − a)/w: c₀s² + c₁s + c₂ = (c₀/w²)λ² + (c₁/w − 2ac₀/w²)λ + (c₂ − ac₁/w + a²c₀/w²).
pub fn in_nm(c: DVec3) -> [f32; 3] {
    let (a, w) = (WAVELENGTH_MIN as f64, (WAVELENGTH_MAX - WAVELENGTH_MIN) as f64);
    let (quadratic, linear) = (c.x / (w * w), c.y / w);
    [quadratic, linear - 2.0 * a * quadratic, c.z - a * linear + a * a * quadratic].map(|v| v as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_have_the_colour_asked_for() {
        for i in 0..=10 {
            for j in 0..=10 {
                for k in 0..=10 {
                    let rgb = DVec3::new(i as f64, j as f64, k as f64) * 0.06 + 0.1;
                    let fitted = color(gauss_newton(rgb, DVec3::ZERO)).0;
                    // What the iteration stops at.
                    assert!(lab(fitted).0.distance(lab(rgb).0) < 1e-3, "{rgb} {fitted}");
                }
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_function() {
        let c = DVec3::new(3.0, -2.0, 0.3);
        let function = |c: DVec3| lab(color(c).0).0;
        let (value, value_by_c) = color(c);
        let exact = lab(value).1 * value_by_c;
        for axis in 0..3 {
            let h = DVec3::AXES[axis] * 1e-5;
            let numeric = (function(c + h) - function(c - h)) / 2e-5;
            // Central differences err by h²·f‴/6, 1e-10 times a number of order 100.
            assert!((numeric - exact.col(axis)).abs().max_element() < 1e-6, "{axis}");
        }
    }

    #[test]
    fn both_polynomials_are_one() {
        let c = DVec3::new(3.0, -2.0, 0.3);
        let [c0, c1, c2] = in_nm(c);
        for λ in [360.0f32, 500.0, 830.0] {
            let s = (λ as f64 - 360.0) / 470.0;
            let error = ((c0 * λ + c1) * λ + c2) as f64 - ((c.x * s + c.y) * s + c.z);
            // Terms of up to c₀λ² ≈ 9 cancel in f32.
            assert!(error.abs() < 1e-5, "{λ} {error}");
        }
    }
}
