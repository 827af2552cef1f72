//! Spheres.

use super::{AreaSample, Geometry, SurfacePoint, placement, require_orthogonal};
use crate::math::frame::{length, unit};
use crate::math::function::{acos, turn};
use crate::math::ray::{position_error, rounding};
use crate::math::{Bounds, DVec2, DVec3, Frame, INV_PI, Transform, warp};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use std::f64::consts::PI;

pub const NAME: &str = "sphere";
pub const ABOUT: &str = "A sphere; uv are azimuth and polar angle about its z axis.";
pub const EXAMPLES: &[&str] = &[
    r#"<shape type="sphere"/>"#,
    r#"<shape type="sphere"><point name="center" x="1" y="2" z="3"/><float name="radius" value="0.5"/></shape>"#,
];

/// A sphere in world space.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub centre: DVec3,
    pub radius: f64,
    /// Whether normals point inwards.
    pub inward: bool,
    /// See [`Geometry::point_error`](super::Geometry::point_error).
    error: f64,
    /// Rows take world directions to the axes of uv.
    axes: [DVec3; 3],
}

/// What a point outside a sphere sees of it in some direction.
pub struct SphereSample {
    /// From the point (world, unit length).
    pub direction: DVec3,
    /// From the point to the sphere's front.
    pub distance: f64,
    /// A bound of the error of `distance` besides that of the point.
    pub error: f64,
    /// Unit outward normal (world).
    pub n: DVec3,
    pub uv: DVec2,
}

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let (to_world, flip) = placement(params)?;
    let centre = params.vector("center", Some(DVec3::ZERO), "centre in object space")?.unwrap_or(DVec3::ZERO);
    let about = "radius in object space; a negative one turns the surface inside out";
    let radius = params.float_where("radius", 1.0, about, "a finite number other than 0", |r| r != 0.0)?;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis));
    require_orthogonal(params, axes, &[(0, 1), (1, 2)])?;
    Ok(Geometry::Sphere(Sphere::new(&to_world, centre, radius, flip)))
}

impl Sphere {
    pub fn new(to_world: &Transform, centre: DVec3, radius: f64, flip: bool) -> Self {
        // A negative radius is a factor that mirrors all three axes.
        let sign = radius.signum();
        let (centre, radius) = (to_world.point(centre), radius.abs() * length(to_world.vector(DVec3::X)));
        let inward = flip != to_world.mirrors();
        Self {
            error: position_error(centre.abs() + radius),
            centre,
            radius,
            inward: inward != (sign < 0.0),
            axes: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| unit(to_world.vector(axis * sign))),
        }
    }

    /// The point of the sphere nearest to `near`.
    #[inline(always)]
    pub fn point<const UV: bool>(&self, near: DVec3) -> SurfacePoint {
        let outward = unit(near - self.centre);
        let n = if self.inward { -outward } else { outward };
        let p = self.centre + outward * self.radius;
        if !UV {
            return SurfacePoint::plain(p, n, n, self.error);
        }
        let local = DVec3::from(self.axes.map(|axis| axis.dot(outward)));
        let uv = DVec2::new(turn(local.y, local.x), INV_PI * acos(local.z.clamp(-1.0, 1.0)));
        let dp_du = (self.axes[1] * local.x - self.axes[0] * local.y) * (2.0 * PI * self.radius);
        // With ρ the distance from the axis: ∂p/∂θ = (z cos φ, z sin φ, −ρ), and v = θ/π.
        let rho = (local.x * local.x + local.y * local.y).sqrt();
        let around = if rho > 0.0 {
            self.axes[0] * (local.x / rho) + self.axes[1] * (local.y / rho)
        } else {
            self.axes[0]
        };
        let dp_dv = (around * local.z - self.axes[2] * rho) * (PI * self.radius);
        SurfacePoint { p, ng: n, ns: n, uv, dp_du, dp_dv, error: self.error }
    }

    /// See [`Geometry::point_error`].
    pub fn point_error(&self) -> f64 {
        self.error
    }

    /// The area in m² of the surface (world).
    pub fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }

    /// A point of the surface from two numbers in [0, 1), with its density in m⁻²; texture coordinates if `UV`.
    pub fn sample_area<const UV: bool>(&self, u: DVec2) -> AreaSample {
        let way = warp::sphere(u);
        let SurfacePoint { p, uv, .. } = self.point::<UV>(self.centre + way * self.radius);
        // Not that of the point, which is known to fewer digits the smaller the sphere is.
        let n = if self.inward { -way } else { way };
        AreaSample { p, n, uv, pdf: 1.0 / self.area(), primitive: 0, error: self.error }
    }

    /// 1 − cos of the cone that the sphere fills seen from `p`; `None` of a sphere whose outside is its back, from
    /// inside, and from its own wall, half of whose points rounding puts outside: there the cone would be all
    /// that the wall sees inwards.
    ///
    /// With s = r/d: 1 − √(1 − s²) = s²/(1 + √(1 − s²)).
    #[inline]
    pub fn cone(&self, p: DVec3) -> Option<f64> {
        let d2 = (p - self.centre).length_squared();
        // The errors of the wall and of a point next to it.
        let wall = self.radius + 2.0 * self.error;
        let s2 = self.radius * self.radius / d2;
        (d2 > wall * wall && !self.inward).then(|| s2 / (1.0 + (1.0 - s2).sqrt()))
    }

    /// What `p` outside sees in a direction chosen uniformly within [`Sphere::cone`]; `None` at the very rim.
    ///
    /// The line at an angle θ to the centre, d away, has half a chord h = √(r² − d² sin²θ) inside and meets
    /// the front at t = d cosθ − h. The normal there is (tω − dẑ)/r, whose last component −(d sin²θ + h cosθ)/r
    /// does not cancel. A rounding of ω moves the line by d times as much, and h by r/h times that.
    #[inline]
    pub fn sample_cone<const UV: bool>(
        &self,
        p: DVec3,
        u: DVec2,
        one_minus_cos: f64,
    ) -> Option<SphereSample> {
        let towards = self.centre - p;
        let d = length(towards);
        let frame = Frame::about(towards / d);
        let local = warp::cone(u, one_minus_cos);
        let sin2 = local.x * local.x + local.y * local.y;
        let half2 = self.radius * self.radius - d * d * sin2;
        if half2 <= 0.0 {
            return None;
        }
        let half = half2.sqrt();
        let distance = d * local.z - half;
        let n = DVec3::new(distance * local.x, distance * local.y, -(d * sin2 + half * local.z));
        let direction = frame.to_world(local);
        let uv = if UV { self.point::<true>(p + direction * distance).uv } else { DVec2::ZERO };
        let error = self.error + rounding(self.radius * d / half);
        Some(SphereSample { direction, distance, error, n: frame.to_world(n / self.radius), uv })
    }

    /// The least and the greatest coordinates (world).
    pub fn bounds(&self) -> Bounds {
        (self.centre - self.radius, self.centre + self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Ray;
    use crate::math::ray::free_way;
    use crate::shape::accel::Accel;

    /// u is the azimuth from x towards y, v the angle from z; and p moves along with both.
    #[test]
    fn coordinates_run_from_x_to_y_and_from_pole_to_pole() {
        let sphere = Sphere::new(&Transform::IDENTITY, DVec3::ZERO, 2.0, false);
        for (way, uv) in [
            (DVec3::X, (0.0, 0.5)),
            (DVec3::Y, (0.25, 0.5)),
            (-DVec3::X, (0.5, 0.5)),
            (-DVec3::Y, (0.75, 0.5)),
            (DVec3::new(1.0, 1.0, 2f64.sqrt()), (0.125, 0.25)),
        ] {
            let point = sphere.point::<true>(way);
            assert!((point.uv - DVec2::from(uv)).length() < 1e-12, "{way} {}", point.uv);
            const STEP: f64 = 1e-6;
            for tangent in [point.dp_du, point.dp_dv] {
                let moved = sphere.point::<true>(point.p + tangent * STEP).uv - point.uv;
                let expected = if tangent == point.dp_du { DVec2::X } else { DVec2::Y };
                let moved = DVec2::new(moved.x - moved.x.round(), moved.y) / STEP;
                assert!((moved - expected).length() < 1e-4, "{way} {moved}");
            }
        }
    }

    /// As by the transform that a negative radius stands for.
    #[test]
    fn a_negative_radius_turns_the_surface_inside_out() {
        let mirror = Transform::scale(DVec3::splat(-2.0)).unwrap();
        let mirrored = Sphere::new(&mirror, DVec3::ZERO, 1.0, false);
        for flip in [false, true] {
            let sphere = Sphere::new(&Transform::IDENTITY, DVec3::ZERO, -2.0, flip);
            for way in [DVec3::X, DVec3::new(0.3, -0.5, 0.8)] {
                let (point, other) = (sphere.point::<true>(way), mirrored.point::<true>(way));
                assert!(point.ng.dot(way) < 0.0 || flip, "{way}");
                assert!(point.ng.dot(way) > 0.0 || !flip, "{way}");
                assert!(length(point.p - other.p) < 1e-15 && (point.uv - other.uv).length() < 1e-15);
                assert!(length(point.dp_du - other.dp_du) < 1e-14);
            }
            assert_eq!(sphere.area(), mirrored.area());
        }
    }

    /// From near by and far away, up to a hair from the rim, where √ makes roundings a million times as large.
    #[test]
    fn what_is_sampled_is_on_the_sphere_and_is_not_in_its_own_way() {
        let mut nearest_rim = f64::INFINITY;
        for away in [1.01, 3.0, 1e3, 1e7] {
            let sphere = Sphere::new(&Transform::IDENTITY, DVec3::new(0.3, -2.0, 0.7), 0.8, false);
            let p = sphere.centre + unit(DVec3::new(0.2, 0.5, -0.3)) * (away * sphere.radius);
            let accel = Accel::new(&[&Geometry::Sphere(sphere)]);
            let opening = sphere.cone(p).unwrap();
            for i in 0..40_000 {
                let below_one = 1.0 - 0.5f64.powf(f64::from(i) / 1000.0);
                let u = DVec2::new(f64::from(i) * 0.618034 % 1.0, below_one);
                let Some(seen) = sphere.sample_cone::<false>(p, u, opening) else { continue };
                let facing = -seen.direction.dot(seen.n);
                nearest_rim = nearest_rim.min(facing);
                assert!(facing > -1e-15 && (length(seen.n) - 1.0).abs() < 1e-14, "{away} {u}: {}", seen.n);
                let end = free_way(seen.distance, position_error(p) + seen.error);
                assert!(!accel.occluded(&Ray { end, ..Ray::free(p, seen.direction) }), "{away} {u}");
                let from_centre = p + seen.direction * seen.distance - sphere.centre;
                let off = length(from_centre - seen.n * sphere.radius);
                assert!(off < 10.0 * (seen.error + position_error(p)), "{away} {u}: {off}");
            }
        }
        assert!(nearest_rim < 1e-4, "{nearest_rim}");
    }

    #[test]
    fn from_its_own_wall_no_sphere_has_a_cone() {
        for (centre, radius, inward) in
            [(DVec3::ZERO, 1.0, true), (DVec3::ZERO, 1.0, false), (DVec3::new(-70.0, 3.0, 0.2), 1.3, false)]
        {
            let sphere = Sphere::new(&Transform::IDENTITY, centre, radius, inward);
            let wall = (0..1000).map(|i| {
                let way = warp::sphere(DVec2::new(0.37, f64::from(i) / 1000.0));
                sphere.point::<false>(centre + way * radius).p
            });
            let outside = wall.clone().filter(|p| length(*p - centre) > radius).count();
            assert!(outside > 0, "nothing is rounded outwards");
            assert!(wall.into_iter().all(|p| sphere.cone(p).is_none()), "{centre} {inward}");
        }
    }
}
