//! Open cylinders.

use super::patch::on_circle;
use super::{AreaSample, Geometry, SurfacePoint, placement, require_orthogonal};
use crate::math::frame::{length, unit};
use crate::math::function::turn;
use crate::math::ray::position_error;
use crate::math::{Ball, Bounds, DVec2, DVec3, Frame, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use std::f64::consts::PI;

pub const NAME: &str = "cylinder";
pub const ABOUT: &str = "The wall of a cylinder between two points, without caps.";
pub const EXAMPLES: &[&str] = &[
    r#"<shape type="cylinder"/>"#,
    r#"<shape type="cylinder"><point name="p0" x="-1" y="0" z="0"/><point name="p1" x="1" y="0.5" z="0"/>
        <float name="radius" value="0.3"/></shape>"#,
];

/// A cylinder in world space.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    pub start: DVec3,
    /// Unit axis, from `start` (world).
    pub axis: DVec3,
    /// Unit vector across the axis, at u = 0.
    x: DVec3,
    /// Unit vector across the axis, at u = ¼.
    y: DVec3,
    pub length: f64,
    pub radius: f64,
    inward: bool,
    /// See [`Geometry::point_error`].
    error: f64,
}

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let (to_world, flip) = placement(params)?;
    let about = "radius; with a negative one u begins on the other side";
    let radius = params.float_where("radius", 1.0, about, "a finite number other than 0", |r| r != 0.0)?;
    let p0 = params.vector("p0", Some(DVec3::ZERO), "centre of one end")?.unwrap_or(DVec3::ZERO);
    let p1 = params.vector("p1", Some(DVec3::Z), "centre of the other end")?.unwrap_or(DVec3::Z);
    if length(p1 - p0) <= 0.0 {
        return Err(params.error("p1", "the cylinder has no length", "expected two different points"));
    }
    let frame = Frame::about(unit(p1 - p0));
    let axes = [frame.s, frame.t, frame.n].map(|axis| to_world.vector(axis));
    require_orthogonal(params, axes, &[(0, 1)])?;
    Ok(Geometry::Cylinder(Cylinder::new(&to_world, p0, p1, radius, flip)))
}

impl Cylinder {
    pub fn new(to_world: &Transform, p0: DVec3, p1: DVec3, radius: f64, inward: bool) -> Self {
        let frame = Frame::about(unit(p1 - p0));
        let start = to_world.point(p0);
        let along = to_world.point(p1) - start;
        // A negative radius turns x and y about the axis by half a turn, and nothing else: as in Mitsuba, the
        // outside stays the outside.
        let sign = radius.signum();
        let axis = unit(along);
        let [around, ahead] = [frame.s, frame.t].map(|across| to_world.vector(across * sign));
        // Matrices of a few decimals are not quite orthogonal, but the wall is round: a point that is sampled beside it
        // would be hidden by it.
        let x = unit(around - axis * axis.dot(around));
        let y = axis.cross(x);
        let (length, radius) = (length(along), radius.abs() * length(around));
        Self {
            start,
            axis,
            x,
            y: if y.dot(ahead) < 0.0 { -y } else { y },
            length,
            radius,
            inward,
            // Each coordinate of the wall is at most that of the start, the length and the radius together.
            error: position_error(start.abs() + (length + radius)),
        }
    }

    /// See [`Geometry::normal_change`].
    pub fn normal_change(&self, dp: DVec3) -> DVec3 {
        let around = dp - self.axis * dp.dot(self.axis);
        around * (if self.inward { -1.0 } else { 1.0 } / self.radius)
    }

    /// The point of the wall nearest to `near`.
    pub fn point<const UV: bool>(&self, near: DVec3) -> SurfacePoint {
        let o = near - self.start;
        let z = o.dot(self.axis);
        let outward = unit(o - self.axis * z);
        let n = if self.inward { -outward } else { outward };
        let p = self.start + self.axis * z + outward * self.radius;
        if !UV {
            return SurfacePoint::plain(p, n, n, self.error);
        }
        let (x, y) = (outward.dot(self.x), outward.dot(self.y));
        let uv = DVec2::new(turn(y, x), z / self.length);
        let dp_du = (self.y * x - self.x * y) * (2.0 * PI * self.radius);
        SurfacePoint { p, ng: n, ns: n, uv, dp_du, dp_dv: self.axis * self.length, error: self.error }
    }

    /// See [`Geometry::point_error`].
    pub fn point_error(&self) -> f64 {
        self.error
    }

    /// The area in m² of the surface (world).
    pub fn area(&self) -> f64 {
        2.0 * PI * self.radius * self.length
    }

    /// A point of the surface from two numbers in [0, 1), with its density in m⁻².
    pub fn sample_area(&self, u: DVec2) -> AreaSample {
        let c = on_circle(u.x);
        let outward = self.x * c.x + self.y * c.y;
        let p = self.start + self.axis * (u.y * self.length) + outward * self.radius;
        let n = if self.inward { -outward } else { outward };
        AreaSample { p, n, uv: u, pdf: 1.0 / self.area(), primitive: 0, error: self.error }
    }

    /// The least and the greatest coordinates (world).
    pub fn bounds(&self) -> Bounds {
        bounds(self.start, self.axis, self.length, self.radius)
    }

    /// The smallest ball that contains it.
    pub fn ball(&self) -> Ball {
        let half = 0.5 * self.length;
        let radius = (half * half + self.radius * self.radius).sqrt();
        Ball { centre: self.start + self.axis * half, radius }
    }
}

/// The corners of a box around a cylinder with a unit axis.
pub fn bounds(start: DVec3, axis: DVec3, length: f64, radius: f64) -> Bounds {
    let half = axis.map(|a| ((1.0 - a) * (1.0 + a)).max(0.0).sqrt()) * radius;
    let end = start + axis * length;
    (start.min(end) - half, start.max(end) + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat4, DVec4};

    /// Of a rotation by 50 degrees about (1, 2, 3), mirrored or not.
    #[test]
    fn points_that_are_sampled_lie_on_the_wall_whatever_the_decimals_of_a_matrix() {
        let columns =
            [[0.668, 0.665, -0.333], [-0.563, 0.745, 0.358], [0.486, -0.052, 0.872]].map(DVec3::from_array);
        for mirror in [1.0, -1.0] {
            let [x, y, z] = [columns[0] * mirror, columns[1], columns[2]].map(|column| column.extend(0.0));
            let to_world = Transform::from_matrix(DMat4::from_cols(x, y, z, DVec4::W)).unwrap();
            let cylinder = Cylinder::new(&to_world, DVec3::ZERO, DVec3::Z, 0.05, false);
            for i in 0..64 {
                let u = DVec2::new((f64::from(i) + 0.5) / 64.0, 0.3);
                let sample = cylinder.sample_area(u);
                let from_axis = sample.p - cylinder.axis * sample.p.dot(cylinder.axis);
                assert!((length(from_axis) / cylinder.radius - 1.0).abs() < 1e-14, "{mirror} {i}");
                let point = cylinder.point::<true>(sample.p);
                assert!(length(point.p - sample.p) < 1e-15 && (point.uv - u).abs().max_element() < 1e-12);
            }
        }
    }

    #[test]
    fn a_negative_radius_moves_u_by_half_a_turn_and_the_outside_stays_outside() {
        let near = DVec3::new(0.3, 0.4, 0.25);
        let [a, b] = [0.5, -0.5].map(|radius| {
            Cylinder::new(&Transform::IDENTITY, DVec3::ZERO, DVec3::Z, radius, false).point::<true>(near)
        });
        assert!(length(a.p - near) < 1e-15 && length(b.p - near) < 1e-15);
        assert!(a.ng.dot(near) > 0.0 && b.ng.dot(near) > 0.0);
        assert!((a.uv - b.uv).abs().abs_diff_eq(DVec2::new(0.5, 0.0), 1e-12), "{} {}", a.uv, b.uv);
        assert!(length(a.dp_du - b.dp_du) < 1e-14);
    }
}
