//! The way from one point to another through refracting interfaces.
//!
//! Which interfaces is read off the straight line between the two. Then a ray is shot and bent at each of them by Snell's law, and its
//! direction is corrected until it meets the other point: Newton's method in two unknowns, whose derivatives are those of the ray with respect to
//! its direction, carried along (Igehy 1999, "Tracing Ray Differentials"). At an interface with the normal n against the
//! direction d, the index ratio ν and the cosines c and c′ = √(1 − ν²(1 − c²)) on its two sides,
//!
//! d′ = ν d + (ν c − c′) n, so that ∂d′ = ν ∂d + (ν ∂c − ∂c′) n + (ν c − c′) ∂n, ∂c = −(∂d·n + d·∂n), ∂c′ = ν² c ∂c / c′,
//!
//! and on a flight of length t to a surface of normal g, ∂p′ = ∂p + t ∂d − d g·(∂p + t ∂d)/(g·d). ∂n follows from ∂p′ and how
//! the surface is curved.

use crate::bsdf::{Bsdf, Sample};
use crate::integrator::Counters;
use crate::integrator::path::side_towards;
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, Frame, Ray, length};
use crate::scene::{Scene, Shape, Side};
use crate::spectrum::{Spectrum, Wavelengths};

/// More interfaces than these are not tried.
const MOST_INTERFACES: usize = 8;

/// Corrections of a direction; the fourth is seldom needed.
const CORRECTIONS: usize = 12;

/// How often a correction that leads away is halved.
const HALVINGS: usize = 6;

/// A ray has met a point that it misses by less than this part of their distance.
const MET: f64 = 1.0 / (1u64 << 26) as f64;

/// The number for the choice of a lobe that is above every probability of reflection.
const NOT_REFLECTED: f64 = 1.0 - f64::EPSILON / 2.0;

/// A way through interfaces.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Unit direction in which it leaves the first point.
    pub direction: DVec3,
    pub interfaces: u32,
    /// What becomes of radiance on the way back.
    pub transmittance: Spectrum,
    /// With which probability a path goes through rather than being reflected.
    pub chance: f64,
    /// The square of the index at the second point over that at the first.
    pub eta2: f64,
    /// Area across the ray at the second point for each unit of solid angle at the first.
    pub spread: f64,
    /// From the last interface to where it passes the second point.
    pub last: Ray,
    /// By how much it misses that.
    pub miss: f64,
}

/// A ray after the last interface, with its derivatives by two angles of its first direction.
struct Bent {
    ray: Ray,
    transmittance: Spectrum,
    chance: f64,
    eta2: f64,
    /// Of the place where the ray is nearest to the point, across the ray.
    derivatives: [DVec3; 2],
    distance: f64,
    /// From there to the point.
    miss: DVec3,
}

impl Link {
    /// From a point on a primitive to another point at `distance` in unit direction `straight`; `None` if there is nothing but air
    /// between them, or something else than refracting interfaces, or more of them than `most`, or if no way is found.
    pub fn find(
        scene: &Scene,
        from: (DVec3, u32),
        (straight, distance): (DVec3, f64),
        most: usize,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> Option<Self> {
        if !scene.through_glass.as_ref()?.may_be_between(from.0, straight, distance) {
            return None;
        }
        let mut interfaces = [0; MOST_INTERFACES];
        let interfaces = interfaces_between(scene, from, (straight, distance), &mut interfaces, counters)?;
        if interfaces.is_empty() || interfaces.len() > most {
            return None;
        }
        let to = from.0 + straight * distance;
        let mut bend = |direction| Bent::new(scene, from, direction, interfaces, to, λ, counters);
        let mut direction = straight;
        let mut bent = bend(direction)?;
        for _ in 0..CORRECTIONS {
            let (step, spread) = bent.correction()?;
            if length(bent.miss) <= MET * distance {
                return Some(Self {
                    direction,
                    interfaces: interfaces.len() as u32,
                    transmittance: bent.transmittance,
                    chance: bent.chance,
                    eta2: bent.eta2,
                    spread,
                    last: Ray { end: bent.distance, ..bent.ray },
                    miss: length(bent.miss),
                });
            }
            let frame = Frame::about(direction);
            let step = frame.s * step.x + frame.t * step.y;
            (direction, bent) = (0..HALVINGS).find_map(|halved| {
                let next = unit(direction + step * (1.0 / (1u32 << halved) as f64));
                let better =
                    bend(next).filter(|next| next.miss.length_squared() < bent.miss.length_squared());
                better.map(|bent| (next, bent))
            })?;
        }
        None
    }
}

/// The shapes, by their first primitives, that the straight line goes through; `None` if one of them does not refract.
fn interfaces_between<'a>(
    scene: &Scene,
    (mut p, mut primitive): (DVec3, u32),
    (straight, mut distance): (DVec3, f64),
    interfaces: &'a mut [u32; MOST_INTERFACES],
    counters: &mut Counters,
) -> Option<&'a [u32]> {
    let mut count = 0;
    loop {
        let ray = Ray::leaving(p, straight, distance, primitive);
        counters.rays += 1;
        let Some(hit) = scene.accel.closest(&ray) else { return Some(&interfaces[..count]) };
        let (shape, _) = refracting(scene, hit.primitive)?;
        *interfaces.get_mut(count)? = shape.first_primitive;
        (p, primitive, distance) = (ray.at(hit.t), hit.primitive, distance - hit.t);
        count += 1;
    }
}

/// The shape of a primitive, and its number there, if all that the shape does besides reflecting is refract.
fn refracting(scene: &Scene, primitive: u32) -> Option<(&Shape, u32)> {
    if scene.instances.have(primitive) {
        return None;
    }
    let (shape, local) = scene.shape_of(primitive);
    shape.refracts().then_some((shape, local))
}

impl Bent {
    fn new(
        scene: &Scene,
        (p, primitive): (DVec3, u32),
        direction: DVec3,
        interfaces: &[u32],
        to: DVec3,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> Option<Self> {
        let frame = Frame::about(direction);
        let (mut dp, mut dd) = ([DVec3::ZERO; 2], [frame.s, frame.t]);
        let mut ray = Ray::leaving(p, direction, f64::INFINITY, primitive);
        let (mut transmittance, mut chance, mut eta2) = (Spectrum::ONE, 1.0, 1.0);
        for interface in interfaces {
            counters.rays += 1;
            let hit = scene.accel.closest(&ray)?;
            let (shape, local) = refracting(scene, hit.primitive)?;
            if shape.first_primitive != *interface {
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
            let frame = Frame::about(point.ns);
            let wo = frame.to_local(-d);
            let side = side_towards(shape, wo.z);
            let material = &scene.materials[side.material as usize];
            let sample = material.at(&point, λ).sample(wo, NOT_REFLECTED, DVec2::ZERO)?;
            if !goes_through(side, wo, &sample) {
                return None;
            }
            transmittance = transmittance * sample.weight * sample.pdf as f32;
            chance *= sample.pdf;
            eta2 *= sample.eta * sample.eta;
            if !sample.null {
                let facing = wo.z.signum();
                let (ratio, near, far) = (1.0 / sample.eta, wo.z.abs(), sample.wi.z.abs());
                for (dp, dd) in dp.iter().zip(&mut dd) {
                    let turned = shape.geometry.normal_change(local, &hit, &point, *dp) * facing;
                    let n = point.ns * facing;
                    let near_change = -(dd.dot(n) + d.dot(turned));
                    let far_change = ratio * ratio * near * near_change / far;
                    *dd =
                        *dd * ratio + n * (ratio * near_change - far_change) + turned * (ratio * near - far);
                }
            }
            ray = Ray::leaving(point.p, frame.to_world(sample.wi), f64::INFINITY, hit.primitive);
        }
        let d = ray.direction;
        let towards = to - ray.origin;
        let distance = towards.dot(d);
        let across = |v: DVec3| v - d * v.dot(d);
        let derivatives = [0, 1].map(|i| across(dp[i] + dd[i] * distance));
        let miss = across(towards);
        (distance > 0.0).then_some(Self { ray, transmittance, chance, eta2, derivatives, distance, miss })
    }

    /// By which angles the first direction must change, and the area across the ray for each unit of solid angle; `None` where all
    /// light comes together.
    fn correction(&self) -> Option<(DVec2, f64)> {
        let frame = Frame::about(self.ray.direction);
        let flat = |v: DVec3| DVec2::new(v.dot(frame.s), v.dot(frame.t));
        let ([a, b], miss) = (self.derivatives.map(flat), flat(self.miss));
        let determinant = a.perp_dot(b);
        let step = DVec2::new(miss.perp_dot(b), a.perp_dot(miss)) / determinant;
        (determinant != 0.0 && step.is_finite()).then_some((step, determinant.abs()))
    }
}

/// Whether what a side made of ωo is of what goes through an interface, with all wavelengths.
pub fn goes_through(side: Side, wo: DVec3, sample: &Sample) -> bool {
    side.traits.refracts && sample.delta && !sample.dispersed && wo.z * sample.wi.z < 0.0
}
