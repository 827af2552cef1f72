//! Maps from the unit square to the domains that are sampled, each with its density.

use super::function::{sin_cos_eighth, sin_cos_turn};
use super::{DVec2, DVec3, INV_PI};

/// Square to unit disk, area-preserving and continuous (Shirley & Chiu 1997). Density 1/π.
#[inline(always)]
pub fn disk_concentric(u: DVec2) -> DVec2 {
    let (x, y) = (2.0 * u.x - 1.0, 2.0 * u.y - 1.0);
    let steep = y.abs() >= x.abs();
    let (large, small) = if steep { (y, x) } else { (x, y) };
    if large == 0.0 {
        return DVec2::ZERO;
    }
    // The angle from the nearer axis is an eighth of a turn times the ratio of the coordinates.
    let (sin, cos) = sin_cos_eighth(small / large / 8.0);
    let (along, across) = (large * cos, large * sin);
    if steep { DVec2::new(across, along) } else { DVec2::new(along, across) }
}

/// Square to upper hemisphere with density cosθ/π.
#[inline(always)]
pub fn cosine_hemisphere(u: DVec2) -> DVec3 {
    let d = disk_concentric(u);
    // 1 − r² would cancel near the rim; there max(|x|,|y|) of the square gives 1 − r exactly.
    let r = (2.0 * u.x - 1.0).abs().max((2.0 * u.y - 1.0).abs());
    DVec3::new(d.x, d.y, ((1.0 - r) * (1.0 + r)).sqrt())
}

/// Density of [`cosine_hemisphere`] at a local direction.
#[inline(always)]
pub fn cosine_hemisphere_pdf(w: DVec3) -> f64 {
    w.z.max(0.0) * INV_PI
}

/// Square to unit sphere, uniform. Density 1/(4π).
#[inline]
pub fn sphere(u: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * u.y;
    let r = 2.0 * (u.y * (1.0 - u.y)).sqrt();
    let (sin, cos) = sin_cos_turn(u.x);
    DVec3::new(r * cos, r * sin, z)
}

/// Square to the cone of directions about +z whose 1 − cosθ is below `one_minus_cos`, uniform.
///
/// The opening is given as 1 − cosθ because for the small cones of distant spheres cosθ itself has no digits.
#[inline]
pub fn cone(u: DVec2, one_minus_cos: f64) -> DVec3 {
    let h = u.y * one_minus_cos;
    let r = (h * (2.0 - h)).sqrt();
    let (sin, cos) = sin_cos_turn(u.x);
    DVec3::new(r * cos, r * sin, 1.0 - h)
}

/// Density of [`cone`] with respect to solid angle.
#[inline]
pub fn cone_pdf(one_minus_cos: f64) -> f64 {
    0.5 * INV_PI / one_minus_cos
}

/// Square to the triangle of barycentric (u, v) with u, v ≥ 0 and u + v ≤ 1, uniform (Heitz 2019).
#[inline]
pub fn triangle(u: DVec2) -> DVec2 {
    if u.y > u.x {
        let x = 0.5 * u.x;
        DVec2::new(x, u.y - x)
    } else {
        let y = 0.5 * u.y;
        DVec2::new(u.x - y, y)
    }
}

/// A number in [0, 1) to one whose density is linear, from `a` at 0 to `b` at 1 up to a factor, both ≥ 0.
///
/// The root of a x + (b − a) x²/2 = u (a + b)/2, in the form that nothing cancels in.
#[inline]
pub fn linear(u: f64, a: f64, b: f64) -> f64 {
    let sum = a + b;
    if sum <= 0.0 {
        return u;
    }
    // Parts of the sum, whose squares stay in range.
    let (a, b) = (a / sum, b / sum);
    let divisor = a + (a * a + u * (b - a)).max(0.0).sqrt();
    if divisor > 0.0 { (u / divisor).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::length;

    #[test]
    fn the_distribution_of_a_linear_density_is_undone() {
        for (a, b) in [(1.0, 1.0), (0.0, 2.0), (3.0, 0.0), (0.25, 8.0), (1e-300, 1e-300), (1e200, 1.0)] {
            for u in (1..64).map(|i| i as f64 / 64.0) {
                let x = linear(u, a, b);
                let distribution = x * (2.0 * a / (a + b) + (b - a) / (a + b) * x);
                assert!((distribution - u).abs() < 1e-12, "{a} {b} {u}");
            }
        }
        assert_eq!(linear(0.25, 0.0, 0.0), 0.25);
        assert_eq!(linear(0.0, 0.0, 1.0), 0.0);
    }

    fn grid() -> impl Iterator<Item = DVec2> {
        (0..64)
            .flat_map(|i| (0..64).map(move |j| DVec2::new((i as f64 + 0.5) / 64.0, (j as f64 + 0.5) / 64.0)))
    }

    /// |∂x/∂u × ∂x/∂v| by central differences.
    fn area_factor(f: impl Fn(DVec2) -> DVec3, u: DVec2) -> f64 {
        let h = 1e-5;
        let dx = (f(u + DVec2::X * h) - f(u - DVec2::X * h)) / (2.0 * h);
        let dy = (f(u + DVec2::Y * h) - f(u - DVec2::Y * h)) / (2.0 * h);
        length(dx.cross(dy))
    }

    #[test]
    fn density_times_jacobian_is_one() {
        for u in grid() {
            if (u.x - u.y).abs() < 0.01 || (u.x + u.y - 1.0).abs() < 0.01 {
                continue; // the maps are continuous but not smooth across the diagonals
            }
            let disk = area_factor(|u| disk_concentric(u).extend(0.0), u);
            assert!((disk * INV_PI - 1.0).abs() < 1e-6, "disk {u}");
            let cosine = area_factor(cosine_hemisphere, u) * cosine_hemisphere_pdf(cosine_hemisphere(u));
            assert!((cosine - 1.0).abs() < 1e-5, "cosine {u} {cosine}");
            assert!((area_factor(sphere, u) * 0.25 * INV_PI - 1.0).abs() < 1e-6, "sphere {u}");
            assert!((area_factor(|u| cone(u, 0.3), u) * cone_pdf(0.3) - 1.0).abs() < 1e-6, "cone {u}");
            assert!((area_factor(|u| triangle(u).extend(0.0), u) * 2.0 - 1.0).abs() < 1e-6, "triangle {u}");
        }
    }

    #[test]
    fn directions_have_unit_length() {
        for u in grid() {
            for w in [cosine_hemisphere(u), sphere(u), cone(u, 1e-9), cone(u, 2.0)] {
                assert!((length(w) - 1.0).abs() < 1e-14);
            }
        }
    }
}
