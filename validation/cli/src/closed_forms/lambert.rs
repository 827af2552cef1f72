//! Lambert's formula: irradiance from a polygon of uniform radiance.

use validation::scatterer::DVec3;

/// Irradiance at the origin of a plane with normal +z, from a polygon of radiance 1 wholly above the plane.
///
/// E = ½ |Σ θᵢ n·Γᵢ|, θᵢ the angle that edge i subtends, Γᵢ the unit normal of its plane through the origin
/// (Lambert, Photometria, 1760; Arvo 1995, "Analytic Methods for Simulated Light Transport", eq. 2.7).
pub fn irradiance(polygon: &[DVec3]) -> f64 {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let sum: f64 = edges
        .map(|(a, b)| {
            let across = a.cross(*b);
            let length = across.dot(across).sqrt();
            if length == 0.0 { 0.0 } else { libm::atan2(length, a.dot(*b)) * across.z / length }
        })
        .sum();
    0.5 * sum.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_rectangle_above_its_corner_has_the_form_factor_of_the_handbooks() {
        let (a, b, c) = (1.0, 0.6, 0.8);
        let corners = [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)].map(|(x, y)| DVec3::new(x, y, c));
        // Howell's catalogue of configuration factors, B-4.
        let part = |x: f64, y: f64| {
            let root = (1.0 + x * x).sqrt();
            x / root * libm::atan(y / root)
        };
        let factor = (part(a / c, b / c) + part(b / c, a / c)) / (2.0 * PI);
        assert!((irradiance(&corners) - PI * factor).abs() < 1e-14);
    }

    #[test]
    fn the_hemisphere_has_irradiance_pi() {
        let horizon: Vec<DVec3> = (0..1000)
            .map(|i| {
                let (sin, cos) = libm::sincos(2.0 * PI * f64::from(i) / 1000.0);
                DVec3::new(cos, sin, 0.0)
            })
            .collect();
        assert!((irradiance(&horizon) - PI).abs() < 1e-12);
    }
}
