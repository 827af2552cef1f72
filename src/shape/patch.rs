//! Flat pieces of a plane: parallelograms and ellipses, in one representation that is tested four at a time.

use super::{AreaSample, SurfacePoint};
use crate::math::frame::{length, unit};
use crate::math::function::{sin_cos_turn, turn};
use crate::math::ray::position_error;
use crate::math::{Ball, Bounds, DVec2, DVec3, Transform, warp};
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// |x|, |y| ≤ 1.
    Square,
    /// x² + y² ≤ 1.
    Circle,
}

/// The points centre + x·e₁ + y·e₂.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub centre: DVec3,
    pub e1: DVec3,
    pub e2: DVec3,
    /// Unit normal on the front side.
    pub n: DVec3,
    pub outline: Outline,
    area: f64,
    /// See [`Geometry::point_error`](super::Geometry::point_error).
    error: f64,
}

impl Patch {
    pub fn new(to_world: &Transform, flip: bool, outline: Outline) -> Self {
        let n = unit(to_world.normal(DVec3::Z));
        let (e1, e2) = (to_world.vector(DVec3::X), to_world.vector(DVec3::Y));
        let unit_area = match outline {
            Outline::Square => 4.0,
            Outline::Circle => PI,
        };
        let centre = to_world.point(DVec3::ZERO);
        Self {
            error: position_error(centre.abs() + e1.abs() + e2.abs()),
            centre,
            e1,
            e2,
            n: if flip { -n } else { n },
            outline,
            area: unit_area * length(e1.cross(e2)),
        }
    }

    /// The same surface elsewhere: by its centre and the vectors from there to the middles of two sides.
    pub fn moved(&self, centre: DVec3, e1: DVec3, e2: DVec3) -> Self {
        let area = self.area * (length(e1.cross(e2)) / length(self.e1.cross(self.e2)));
        let error = position_error(centre.abs() + e1.abs() + e2.abs());
        Self { centre, e1, e2, area, error, ..*self }
    }

    /// The vectors whose products with p − centre are x and y: the dual basis of (e₁, e₂) in the plane.
    pub fn dual(&self) -> (DVec3, DVec3) {
        let normal = self.e1.cross(self.e2);
        let scale = 1.0 / normal.dot(normal);
        (self.e2.cross(normal) * scale, normal.cross(self.e1) * scale)
    }

    /// The area in m² of the surface (world).
    pub fn area(&self) -> f64 {
        self.area
    }

    /// See [`Geometry::point_error`](super::Geometry::point_error).
    pub fn point_error(&self) -> f64 {
        self.error
    }

    /// The point with patch coordinates (x, y).
    #[inline(always)]
    pub fn point<const UV: bool>(&self, x: f64, y: f64) -> SurfacePoint {
        let p = self.centre + self.e1 * x + self.e2 * y;
        if !UV {
            return SurfacePoint::plain(p, self.n, self.n, self.error);
        }
        let (uv, dp_du, dp_dv) = match self.outline {
            Outline::Square => (DVec2::new(0.5 * (x + 1.0), 0.5 * (y + 1.0)), self.e1 * 2.0, self.e2 * 2.0),
            Outline::Circle => {
                let r = (x * x + y * y).sqrt();
                let radial = if r > 0.0 { self.e1 * (x / r) + self.e2 * (y / r) } else { self.e1 };
                let around = (self.e2 * x - self.e1 * y) * (2.0 * PI);
                (DVec2::new(r, turn(y, x)), radial, around)
            }
        };
        SurfacePoint { p, ng: self.n, ns: self.n, uv, dp_du, dp_dv, error: self.error }
    }

    /// A point of the surface from two numbers in [0, 1), with its density in m⁻²; texture coordinates if `UV`.
    #[inline(always)]
    pub fn sample_area<const UV: bool>(&self, u: DVec2) -> AreaSample {
        let d = match self.outline {
            Outline::Square => DVec2::new(2.0 * u.x - 1.0, 2.0 * u.y - 1.0),
            Outline::Circle => warp::disk_concentric(u),
        };
        let SurfacePoint { p, ng, uv, .. } = self.point::<UV>(d.x, d.y);
        AreaSample { p, n: ng, uv, pdf: 1.0 / self.area, primitive: 0, error: self.error }
    }

    /// The corners of the parallelogram, or of the one about the ellipse.
    pub fn corners(&self) -> [DVec3; 4] {
        [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
            .map(|(x, y)| self.centre + self.e1 * x + self.e2 * y)
    }

    /// The least and the greatest coordinates (world).
    pub fn bounds(&self) -> Bounds {
        let half = match self.outline {
            Outline::Square => self.e1.abs() + self.e2.abs(),
            Outline::Circle => (self.e1 * self.e1 + self.e2 * self.e2).map(f64::sqrt),
        };
        (self.centre - half, self.centre + half)
    }

    /// The smallest ball that contains it.
    pub fn ball(&self) -> Ball {
        let Self { e1, e2, .. } = *self;
        let (a, b, c) = (e1.length_squared(), e1.dot(e2), e2.length_squared());
        let squared = match self.outline {
            Outline::Square => a + c + 2.0 * b.abs(),
            // The longer half axis of the ellipse that it may be.
            Outline::Circle => 0.5 * (a + c) + (0.25 * (a - c) * (a - c) + b * b).sqrt(),
        };
        Ball { centre: self.centre, radius: squared.sqrt() }
    }
}

/// A point on the unit circle at a fraction of a turn.
pub fn on_circle(turn: f64) -> DVec2 {
    let (sin, cos) = sin_cos_turn(turn);
    DVec2::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Geometry;
    use glam::DMat4;

    /// A shear keeps areas, though not the lengths of sides.
    #[test]
    fn a_sheared_patch_keeps_its_area() {
        let shear = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3.0, 4.0, 5.0, 1.0,
        ]);
        let shear = Transform::from_matrix(shear).unwrap();
        for (outline, area) in [(Outline::Square, 4.0), (Outline::Circle, PI)] {
            let patch = Patch::new(&shear, false, outline);
            assert!((patch.area() - area).abs() < 1e-14, "{outline:?} {}", patch.area());
            assert_eq!(patch.sample_area::<false>(DVec2::new(0.2, 0.9)).pdf, 1.0 / patch.area());
        }
    }

    /// As Mitsuba 3.9.1 numbers the triangles of its rectangle.
    #[test]
    fn a_rectangle_counts_as_two_triangles() {
        for (outline, second) in [(Outline::Square, 1), (Outline::Circle, 0)] {
            let patch = Patch::new(&Transform::IDENTITY, false, outline);
            let number = |x, y| Geometry::Patch(patch).mitsuba_primitive(0, &patch.point::<true>(x, y));
            assert_eq!([number(-0.5, 0.45), number(0.3, -0.35)], [0, 0]);
            assert_eq!([number(-0.5, 0.55), number(0.35, -0.3)], [second, second]);
        }
    }
}
