//! Irradiance from disks, spheres and cylinders.

use super::irradiance::{floor_under, shown};
use super::{ClosedForm, lambert};
use crate::stage::*;
use std::f64::consts::{FRAC_PI_2, PI};
use validation::scatterer::DVec3;

pub fn cases() -> Vec<ClosedForm> {
    let disk_source = "E = ½πL(1 − (h² + l² − r²)/√((h² + l² + r²)² − 4r²l²)) (Howell's catalogue, B-13)";
    let near =
        |r: f64| shape("disk", &[scale([r; 3]), rotate('x', 180.0), translate([0.0, 0.0, 1.0])], &area(1.0));
    let aside = [scale([0.6; 3]), rotate('x', 180.0), translate([0.8, 0.0, 1.0])];
    let ball = |center: Point, r: f64| floor_under(&sphere(center, r, &area(1.0)));
    vec![
        ClosedForm::new("disk_above", disk_source, floor_under(&near(0.7)), shown(disk(0.7, 1.0, 0.0))),
        ClosedForm::new(
            "disk_aside",
            disk_source,
            floor_under(&shape("disk", &aside, &area(1.0))),
            shown(disk(0.6, 1.0, 0.8)),
        ),
        ClosedForm::new(
            "sphere",
            "E = πL sin²σ cos θ (Nusselt's analogon of a spherical cap)",
            ball([0.5, 0.3, 1.0], 0.4),
            shown(cap([0.5, 0.3, 1.0], 0.4)),
        ),
        // Its surface passes close to the world's origin, where coordinates are small but its rounding errors
        // are not.
        ClosedForm::new(
            "sphere_that_nearly_touches",
            "E = πL sin²σ cos θ (Nusselt's analogon of a spherical cap)",
            ball([0.0, 0.0, 1010.0], 1000.0),
            shown(cap([0.0, 0.0, 1010.0], 1000.0)),
        ),
        ClosedForm::new(
            "sphere_on_the_horizon",
            "a spherical cap cut by the horizon (Snyder 1996, NASA TM 111768, area light of a sphere)",
            ball([1.0, 0.0, 0.2], 0.5),
            shown(cap([1.0, 0.0, 0.2], 0.5)),
        ),
        ClosedForm::new(
            "sphere_below_the_horizon",
            "a spherical cap cut by the horizon (Snyder 1996, NASA TM 111768, area light of a sphere)",
            ball([1.0, 0.0, -0.2], 0.5),
            shown(cap([1.0, 0.0, -0.2], 0.5)),
        )
        .samples(1 << 14),
        ClosedForm::new(
            "cylinder",
            "Lambert's contour integral over the outline: two tangents and the nearer arcs of both rims",
            floor_under(&cylinder()),
            shown(cylinder_answer()),
        )
        .samples(1 << 14),
    ]
}

/// Irradiance from a disk of radius r parallel to the plane at height h, its axis at distance l; by Howell's
/// factor for an element and a parallel disk.
fn disk(r: f64, h: f64, l: f64) -> f64 {
    let sum = h * h + l * l + r * r;
    0.5 * PI * (1.0 - (sum - 2.0 * r * r) / (sum * sum - 4.0 * r * r * l * l).sqrt())
}

/// Irradiance from the cap of half-angle σ = asin(r/d) around a direction at the angle ω from the normal.
///
/// Above the horizon it is π cos ω sin²σ. Cut by the horizon, with γ = asin(cos σ / sin ω): G = −2 sin ω cos
/// σ cos γ + π/2 − γ + sin γ cos γ, H = |cos ω| (cos γ √(sin²σ − cos²γ) + sin²σ asin(cos γ / sin σ)); it is G
/// − H, plus the whole cap if ω < π/2.
fn cap([x, y, z]: Point, r: f64) -> f64 {
    let d2 = x * x + y * y + z * z;
    let (cos, sin2) = (z / d2.sqrt(), r * r / d2);
    let (sin, sinσ, cosσ) = ((1.0 - cos * cos).sqrt(), sin2.sqrt(), (1.0 - sin2).sqrt());
    let whole = PI * cos * sin2;
    if libm::acos(cos) <= FRAC_PI_2 - libm::asin(sinσ) {
        return whole;
    }
    let sinγ = cosσ / sin;
    let cosγ = (1.0 - sinγ * sinγ).sqrt();
    let g = -2.0 * sin * cosσ * cosγ + FRAC_PI_2 - libm::asin(sinγ) + sinγ * cosγ;
    let h = cos.abs() * (cosγ * (sin2 - cosγ * cosγ).max(0.0).sqrt() + sin2 * libm::asin(cosγ / sinσ));
    // The part of the mirrored cap above the horizon is the part of this one below it, and both differ by the
    // whole.
    if cos > 0.0 { whole + g - h } else { g - h }
}

/// Radius 0.3, axis along y through (0.2, 1) in the xz plane, half length 2.
const CYLINDER: (f64, f64, f64, f64) = (0.3, 0.2, 1.0, 2.0);

fn cylinder() -> String {
    let (r, x, z, half) = CYLINDER;
    let end = |name: &str, y: f64| format!("<point name=\"{name}\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
    let (p0, p1, radius) = (end("p0", -half), end("p1", half), float("radius", r));
    format!("<shape type=\"cylinder\">{p0}{p1}{radius}{}</shape>", area(1.0))
}

/// From the origin the wall hides its inside, and the far rims are behind the near ones.
fn cylinder_answer() -> f64 {
    let (r, x, z, half) = CYLINDER;
    let distance = (x * x + z * z).sqrt();
    // At tangent points the radius is perpendicular to the line of sight.
    let reach = libm::acos(r / distance);
    let towards = libm::atan2(-z, -x);
    const STEPS: i32 = 2000;
    let rim = |y: f64| {
        (-STEPS..=STEPS).map(move |i| {
            let (sin, cos) = libm::sincos(towards + reach * f64::from(i) / f64::from(STEPS));
            DVec3::new(x + r * cos, y, z + r * sin)
        })
    };
    lambert::irradiance(&rim(-half).chain(rim(half).rev()).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::quadrature::{Cell, integrate};

    #[test]
    fn caps_agree_with_quadrature() {
        for center in [[0.5, 0.3, 1.0], [1.0, 0.0, 0.2], [1.0, 0.0, -0.2], [0.9, 0.1, 0.0]] {
            let r = 0.5;
            let axis = DVec3::from_array(center);
            let d = axis.dot(axis).sqrt();
            let (axis, low) = (axis / d, (1.0 - r * r / (d * d)).sqrt());
            let (s, t) = axis.any_orthonormal_pair();
            let integrand = |[c, φ]: [f64; 2]| {
                let (sin, cos) = libm::sincos(φ);
                let w = axis * c + (s * cos + t * sin) * (1.0 - c * c).sqrt();
                w.z.max(0.0)
            };
            let cell = Cell { low: [low, 0.0], high: [1.0, 2.0 * PI] };
            let expected = integrate(&[cell], 1e-7, 2_000_000, integrand).value;
            assert!((cap(center, r) - expected).abs() < 1e-6, "{center:?} {} {expected}", cap(center, r));
        }
    }

    #[test]
    fn a_long_cylinder_is_the_infinite_one() {
        // E = πL r/D · cos of the angle to the axis; the ends reduce it only slightly.
        let (r, x, z, _) = CYLINDER;
        let infinite = PI * r * z / (x * x + z * z);
        let ratio = cylinder_answer() / infinite;
        assert!((0.85..1.0).contains(&ratio), "{ratio}");
    }
}
