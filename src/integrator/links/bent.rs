//! A ray through given surfaces, and its derivatives by its direction.
//!
//! Newton's method needs the derivatives of where the ray ends by two angles of its direction, and they are
//! carried along (Igehy 1999, "Tracing Ray Differentials"). At an interface with the normal n against the
//! direction d, the index ratio ν and the cosines c and c′ = √(1 − ν²(1 − c²)) on its two sides,
//!
//! d′ = ν d + (ν c − c′) n, so that ∂d′ = ν ∂d + (ν ∂c − ∂c′) n + (ν c − c′) ∂n, ∂c = −(∂d·n + d·∂n), ∂c′ =
//! ν² c ∂c / c′,
//!
//! and on a flight of length t to a surface of normal g, ∂p′ = ∂p + t ∂d − d g·(∂p + t ∂d)/(g·d). ∂n follows
//! from ∂p′ and how the surface is curved. A mirror is an interface with ν = 1 and c′ = −c.

use super::chain::{Turn, turn};
use super::surfaces::{Surface, specular};
use crate::bsdf::Bsdf;
use crate::integrator::Counters;
use crate::math::{BELOW_ONE, DVec2, DVec3, Frame, Origin, Ray, length};
use crate::scene::{Features, Scene};
use crate::spectrum::{Spectrum, Wavelengths};

/// The number for the choice of a lobe that is below every probability of reflection.
pub const REFLECTED: f64 = 0.0;

/// The number for the choice of a lobe that is above every probability of reflection.
pub const NOT_REFLECTED: f64 = BELOW_ONE;

/// A ray after the last surface, with its derivatives by two angles of its first direction.
pub struct Bent {
    pub ray: Ray,
    /// Factor of radiance that comes back along the ray.
    pub transmittance: Spectrum,
    /// Probability with which a path chooses the lobes along the ray.
    pub chance: f64,
    /// The square of the index at its end over that at its beginning.
    pub eta2: f64,
    /// Derivatives of the place where the ray is nearest to the target, across the ray.
    derivatives: [DVec3; 2],
    pub distance: f64,
    /// Vector from that place to the target.
    pub miss: DVec3,
}

impl Bent {
    /// Traces a ray from a point on a primitive by these surfaces, to where it is nearest to the target `to`;
    /// `None` if it meets other surfaces.
    pub fn new(
        scene: &Scene,
        Origin { p, primitive }: Origin,
        direction: DVec3,
        surfaces: &[Surface],
        to: DVec3,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> Option<Self> {
        let frame = Frame::about(direction);
        let (mut dp, mut dd) = ([DVec3::ZERO; 2], [frame.s, frame.t]);
        let mut ray = Ray::leaving(p, direction, f64::INFINITY, primitive);
        let (mut transmittance, mut chance, mut eta2) = (Spectrum::ONE, 1.0, 1.0);
        for surface in surfaces {
            counters.rays += 1;
            let hit = scene.accel.closest(&ray)?;
            let (shape, local) = specular(scene, hit.primitive)?;
            let (is_it, wanted, lobe) = match surface {
                Surface::Glass(first) => (shape.first_primitive == *first, Turn::Through, NOT_REFLECTED),
                Surface::Mirror(mirror) => (mirror.has(hit.primitive), Turn::Back, REFLECTED),
            };
            if !is_it {
                return None;
            }
            let textured = shape.sides.iter().any(|side| side.traits.textured);
            let point = if textured {
                shape.geometry.point::<true>(&ray, &hit, local)
            } else {
                shape.geometry.point::<false>(&ray, &hit, local)
            };
            let d = ray.direction;
            for (dp, dd) in dp.iter_mut().zip(dd) {
                let moved = *dp + dd * hit.t;
                *dp = moved - d * (moved.dot(point.ng) / d.dot(point.ng));
            }
            let side = shape.side_towards(point.ns.dot(-d));
            let frame = side.frame::<{ Features::ALL }>(&point);
            let wo = frame.to_local(-d);
            let material = &scene.materials[side.material as usize];
            let sample = material.at(&point, λ).sample(wo, lobe, DVec2::ZERO)?;
            if turn(side, wo, &sample) != Some(wanted) {
                return None;
            }
            transmittance = transmittance * sample.weight * sample.pdf as f32;
            chance *= sample.pdf;
            eta2 *= sample.eta * sample.eta;
            if !sample.null {
                let (ratio, near, far) = (1.0 / sample.eta, wo.z.abs(), -sample.wi.z * wo.z.signum());
                let facing = point.ns.dot(-d).signum();
                for (dp, dd) in dp.iter().zip(&mut dd) {
                    let turned = shape.geometry.normal_change(local, &hit, &point, *dp) * facing;
                    let n = point.ns * facing;
                    let near_change = -(dd.dot(n) + d.dot(turned));
                    let far_change = ratio * ratio * near * near_change / far;
                    *dd =
                        *dd * ratio + n * (ratio * near_change - far_change) + turned * (ratio * near - far);
                }
            }
            ray = point.ray(frame.to_world(sample.wi), f64::INFINITY, hit.primitive);
        }
        let d = ray.direction;
        let towards = to - ray.origin;
        let distance = towards.dot(d);
        let across = |v: DVec3| v - d * v.dot(d);
        let derivatives = [0, 1].map(|i| across(dp[i] + dd[i] * distance));
        let miss = across(towards);
        (distance > 0.0).then_some(Self { ray, transmittance, chance, eta2, derivatives, distance, miss })
    }

    /// The Newton step, as two angles of the first direction, and the area across the ray for each unit of
    /// solid angle; `None` at a focus, where that is zero.
    pub fn correction(&self) -> Option<(DVec2, f64)> {
        let frame = Frame::about(self.ray.direction);
        let flat = |v: DVec3| DVec2::new(v.dot(frame.s), v.dot(frame.t));
        let ([a, b], miss) = (self.derivatives.map(flat), flat(self.miss));
        let determinant = a.perp_dot(b);
        let step = DVec2::new(miss.perp_dot(b), a.perp_dot(miss)) / determinant;
        (determinant != 0.0 && step.is_finite()).then_some((step, determinant.abs()))
    }

    /// Distance by which it misses the target.
    pub fn missed(&self) -> f64 {
        length(self.miss)
    }
}
