//! The way from one point to another through refracting interfaces, perhaps by a mirror.
//!
//! Which interfaces is read off the straight line between the two, or the lines by which the first sees the
//! second in the mirror. Then a ray is shot and bent at each of them, and its direction is corrected until it
//! meets the other point: Newton's method in two unknowns, whose derivatives the ray carries along
//! ([`bent`](super::bent)).

use super::bent::{Bent, specular};
use super::mirror::Mirror;
use crate::integrator::Counters;
use crate::math::frame::unit;
use crate::math::{DVec3, Frame, Ray, length};
use crate::scene::Scene;
use crate::spectrum::{Spectrum, Wavelengths};

/// More surfaces than these are not tried.
const MOST_SURFACES: usize = 8;

/// Corrections of a direction; the fourth is seldom needed.
const CORRECTIONS: usize = 12;

/// How often a correction that leads away is halved.
const HALVINGS: usize = 6;

/// A ray has met a point that it misses by less than this part of their distance.
const MET: f64 = 1.0 / (1u64 << 26) as f64;

/// What light meets on its way.
#[derive(Clone, Copy, Debug)]
pub enum Surface<'a> {
    /// Refracts; by the first primitive of its shape.
    Glass(u32),
    Mirror(&'a Mirror),
}

/// A way by surfaces that refract or reflect.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Unit direction in which it leaves the first point.
    pub direction: DVec3,
    pub surfaces: u32,
    /// What becomes of radiance on the way back.
    pub transmittance: Spectrum,
    /// With which probability a path takes the same turns.
    pub chance: f64,
    /// The square of the index at the second point over that at the first.
    pub eta2: f64,
    /// Area across the ray at the second point for each unit of solid angle at the first.
    pub spread: f64,
    /// From the last surface to where it passes the second point.
    pub last: Ray,
    /// By how much it misses that.
    pub miss: f64,
}

/// The surfaces of a way in the making.
struct Chain<'a> {
    surfaces: [Surface<'a>; MOST_SURFACES],
    count: usize,
}

impl<'a> Chain<'a> {
    fn push(&mut self, surface: Surface<'a>) -> Option<()> {
        *self.surfaces.get_mut(self.count)? = surface;
        self.count += 1;
        Some(())
    }

    /// Adds the shapes that the straight line goes through, up to the mirror if one is given; `None` if one
    /// of them does not refract.
    fn read(
        &mut self,
        scene: &Scene,
        (mut p, mut primitive): (DVec3, u32),
        to: DVec3,
        until: Option<&Mirror>,
        counters: &mut Counters,
    ) -> Option<()> {
        let mut distance = length(to - p);
        let straight = (to - p) / distance;
        if !scene.links.as_ref()?.may_be_between(p, straight, distance) {
            return Some(());
        }
        loop {
            let ray = Ray::leaving(p, straight, distance, primitive);
            counters.rays += 1;
            let Some(hit) = scene.accel.closest(&ray) else { return Some(()) };
            if until.is_some_and(|mirror| mirror.has(hit.primitive)) {
                return Some(());
            }
            let (shape, _) = specular(scene, hit.primitive).filter(|(shape, _)| shape.refracts())?;
            self.push(Surface::Glass(shape.first_primitive))?;
            (p, primitive, distance) = (ray.at(hit.t), hit.primitive, distance - hit.t);
        }
    }
}

impl Link {
    /// From a point on a primitive to another point, with one reflection if a mirror is given; `None` if
    /// there is nothing but air between them, or something else than refracting interfaces, or more surfaces
    /// than `most`, or if no way is found.
    pub fn find(
        scene: &Scene,
        from: (DVec3, u32),
        to: DVec3,
        by: Option<&Mirror>,
        most: usize,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> Option<Self> {
        let mut chain = Chain { surfaces: [Surface::Glass(0); MOST_SURFACES], count: 0 };
        let first = match by {
            None => {
                chain.read(scene, from, to, None, counters)?;
                to
            }
            Some(mirror) => {
                let seen = mirror.reflection(from.0, to)?;
                chain.read(scene, from, seen, by, counters)?;
                chain.push(Surface::Mirror(mirror))?;
                chain.read(scene, (seen, mirror.primitives[0]), to, None, counters)?;
                seen
            }
        };
        let surfaces = &chain.surfaces[..chain.count];
        if surfaces.is_empty() || surfaces.len() > most {
            return None;
        }
        let distance = length(first - from.0) + length(to - first);
        let mut bend = |direction| Bent::new(scene, from, direction, surfaces, to, λ, counters);
        let mut direction = unit(first - from.0);
        let mut bent = bend(direction)?;
        for _ in 0..CORRECTIONS {
            let (step, spread) = bent.correction()?;
            let miss = bent.missed();
            if miss <= MET * distance {
                return Some(Self {
                    direction,
                    surfaces: surfaces.len() as u32,
                    transmittance: bent.transmittance,
                    chance: bent.chance,
                    eta2: bent.eta2,
                    spread,
                    last: Ray { end: bent.distance, ..bent.ray },
                    miss,
                });
            }
            let frame = Frame::about(direction);
            let step = frame.s * step.x + frame.t * step.y;
            (direction, bent) = (0..HALVINGS).find_map(|halved| {
                let next = unit(direction + step * (1.0 / (1u32 << halved) as f64));
                let better = bend(next).filter(|next| next.missed() < miss);
                better.map(|bent| (next, bent))
            })?;
        }
        None
    }
}
