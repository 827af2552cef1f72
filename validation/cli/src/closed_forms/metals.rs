//! Metals: mirrors, and the albedo of rough metals by quadrature.

use super::ClosedForm;
use super::interfaces::{SKY, stage};
use crate::stage::*;
use std::f64::consts::PI;
use validation::quadrature::{Cell, integrate};
use validation::scatterer::DVec3;

pub fn cases() -> Vec<ClosedForm> {
    let mut cases = vec![];
    let index = |eta: f64, k: f64| float("eta", eta) + &float("k", k);
    for (degrees, eta, k) in [(0.0, 0.2, 3.0), (60.0, 0.2, 3.0), (60.0, 2.8, 3.2), (85.0, 2.8, 3.2)] {
        let source = "Fresnel's equations with a complex index (Born & Wolf §14.2)";
        let pane = shape("rectangle", &[scale([100.0; 3])], &bsdf("conductor", &index(eta, k)));
        let name = format!("mirror_{eta}_{k}_{degrees}");
        let expected = reflectance(libm::cos(f64::to_radians(degrees)), eta, k);
        cases.push(ClosedForm::new(name, source, stage(degrees, SKY, &pane), expected).samples(1 << 6));
    }
    for (shape_name, alpha, degrees) in [("ggx", 0.4, 30.0), ("ggx", 0.1, 70.0), ("beckmann", 0.3, 45.0)] {
        let source = "∫ f cos θ dω, f = FDG/(4 cos θ cos θ′) (Walter et al. 2007, eqs 20, 25–27, 33, 34)";
        let distribution = format!("<string name=\"distribution\" value=\"{shape_name}\"/>");
        let wears = bsdf("roughconductor", &(index(0.2, 3.0) + &float("alpha", alpha) + &distribution));
        let pane = shape("rectangle", &[], &wears);
        let scene = stage(degrees, &constant(1.0), &pane).replace(&path(-1), &path(2));
        let expected = albedo(shape_name == "ggx", alpha, degrees);
        let name = format!("rough_{shape_name}_{alpha}_{degrees}");
        cases.push(ClosedForm::new(name, source, scene, expected).samples(1 << 14));
    }
    cases
}

/// Real and imaginary part.
type Complex = (f64, f64);

fn multiply((a, b): Complex, (c, d): Complex) -> Complex {
    (a * c - b * d, a * d + b * c)
}

/// The principal square root.
fn root((a, b): Complex) -> Complex {
    let size = (a * a + b * b).sqrt();
    let re = (0.5 * (size + a)).max(0.0).sqrt();
    (re, (0.5 * (size - a)).max(0.0).sqrt() * if b < 0.0 { -1.0 } else { 1.0 })
}

/// |(a − b)/(a + b)|²
fn ratio((a, b): Complex, (c, d): Complex) -> f64 {
    ((a - c) * (a - c) + (b - d) * (b - d)) / ((a + c) * (a + c) + (b + d) * (b + d))
}

/// The reflectance of a metal, with n = η − ik: r⊥ = (cos − w)/(cos + w), r∥ = (n²cos − w)/(n²cos + w), w =
/// √(n² − sin²).
pub fn reflectance(cos: f64, eta: f64, k: f64) -> f64 {
    let n2 = multiply((eta, -k), (eta, -k));
    let w = root((n2.0 - (1.0 - cos * cos), n2.1));
    0.5 * (ratio((cos, 0.0), w) + ratio((n2.0 * cos, n2.1 * cos), w))
}

/// The share of a uniform hemisphere's radiance that is reflected at `degrees`: over facets m with density D
/// cos θₘ, F G₁G₁ (ω·m)/(cos θ cos θₘ).
fn albedo(ggx: bool, alpha: f64, degrees: f64) -> f64 {
    let (sin, cos) = libm::sincos(f64::to_radians(degrees));
    let wo = DVec3::new(sin, 0.0, cos);
    let masking = |w: DVec3| {
        let tan = ((1.0 - w.z * w.z).max(0.0)).sqrt() / w.z;
        let a = 1.0 / (alpha * tan);
        if ggx {
            2.0 / (1.0 + (1.0 + 1.0 / (a * a)).sqrt())
        } else if a < 1.6 {
            (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
        } else {
            1.0
        }
    };
    let integrand = |[u, φ]: [f64; 2]| {
        let tan2 = alpha * alpha * if ggx { u / (1.0 - u) } else { -libm::log(1.0 - u) };
        let cosm = 1.0 / (1.0 + tan2).sqrt();
        let sinm = (1.0 - cosm * cosm).sqrt();
        let (s, c) = libm::sincos(φ);
        let m = DVec3::new(sinm * c, sinm * s, cosm);
        let across = wo.dot(m);
        let wi = m * (2.0 * across) - wo;
        if across <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        reflectance(across, 0.2, 3.0) * masking(wo) * masking(wi) * across / (wo.z * cosm)
    };
    let cell = Cell { low: [0.0, 0.0], high: [1.0, PI] };
    integrate(&[cell], 1e-5, 4_000_000, integrand).value / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_absorption_metal_is_glass() {
        for degrees in [0.0, 40.0, 80.0] {
            let glass = super::super::interfaces::reflectance(degrees, 1.5);
            assert!((reflectance(libm::cos(f64::to_radians(degrees)), 1.5, 0.0) - glass).abs() < 1e-14);
        }
    }
}
