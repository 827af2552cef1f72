//! The way from one point to another through refracting interfaces, perhaps by a mirror.
//!
//! Which interfaces is read off the straight line between the two, or the lines by which the first sees the
//! second in the mirror. Then a ray is shot and bent at each of them, and its direction is corrected until it
//! meets the other point: Newton's method in two unknowns, whose derivatives the ray carries along
//! ([`bent`](super::bent)).

use super::SAME;
use super::bent::{Bent, specular};
use super::element::Element;
use super::lens::Starts;
use crate::integrator::Counters;
use crate::math::frame::unit;
use crate::math::{DVec3, Frame, Origin, Ray, length};
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
    Mirror(&'a Element),
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

    /// Whether it leads through a lens, in and out: there may be several such ways, which others look for.
    fn is_lens(&self, scene: &Scene) -> bool {
        match self.surfaces[..self.count] {
            [Surface::Glass(a), Surface::Glass(b)] if a == b => {
                scene.links.as_ref().is_some_and(|links| links.lenses.have(a))
            }
            _ => false,
        }
    }

    /// Adds the shapes that the straight line goes through, up to the mirror if one is given; `None` if one
    /// of them does not refract.
    fn read(
        &mut self,
        scene: &Scene,
        Origin { mut p, mut primitive }: Origin,
        to: DVec3,
        until: Option<&Element>,
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

/// What is to be looked for: ways by these surfaces to a point, from each of some directions.
pub struct Search<'a> {
    scene: &'a Scene,
    from: Origin,
    to: DVec3,
    chain: Chain<'a>,
    starts: Starts,
    /// Whether ways begin there, and not only near by.
    exact: bool,
    /// About how far it is.
    distance: f64,
}

impl<'a> Search<'a> {
    /// For ways from a point on a primitive to another point, by a mirror or a lens if one is given; `None`
    /// if there is nothing but air between them, or something else than refracting interfaces, or more
    /// surfaces than `most`.
    pub fn new(
        scene: &'a Scene,
        from: Origin,
        to: DVec3,
        by: Option<&'a Element>,
        most: usize,
        counters: &mut Counters,
    ) -> Option<Self> {
        let mut chain = Chain { surfaces: [Surface::Glass(0); MOST_SURFACES], count: 0 };
        let mut lens = None;
        let first = match by {
            None => {
                chain.read(scene, from, to, None, counters)?;
                if chain.is_lens(scene) {
                    return None;
                }
                to
            }
            Some(element) => match element.lens() {
                Some(found) => {
                    let glass = Surface::Glass(element.primitives[0]);
                    chain.push(glass)?;
                    (0..found.inner).try_for_each(|_| chain.push(Surface::Mirror(element)))?;
                    chain.push(glass)?;
                    lens = Some(found);
                    found.ball.centre
                }
                None => {
                    let seen = element.reflection(from.p, to)?;
                    chain.read(scene, from, seen, by, counters)?;
                    chain.push(Surface::Mirror(element))?;
                    let mirrored = Origin { p: seen, primitive: element.primitives[0] };
                    chain.read(scene, mirrored, to, None, counters)?;
                    seen
                }
            },
        };
        if chain.count == 0 || chain.count > most {
            return None;
        }
        let starts = match lens {
            Some(lens) => lens.ways(from.p, to),
            None => Starts::one(unit(first - from.p)),
        };
        let distance = length(first - from.p) + length(to - first);
        Some(Self { scene, from, to, chain, starts, exact: lens.is_some(), distance })
    }

    /// The ways there are.
    pub fn links<'s>(
        &'s self,
        λ: &'s Wavelengths,
        counters: &'s mut Counters,
    ) -> impl Iterator<Item = Link> + 's {
        self.starts.list().iter().filter_map(move |start| {
            // Corrections must not lead to a way that begins at another start.
            let link = self.link(*start, λ, counters)?;
            (!self.exact || length(link.direction - *start) < SAME).then_some(link)
        })
    }

    /// The way that a direction leads to, by Newton's method.
    fn link(&self, mut direction: DVec3, λ: &Wavelengths, counters: &mut Counters) -> Option<Link> {
        let surfaces = &self.chain.surfaces[..self.chain.count];
        let mut bend =
            |direction| Bent::new(self.scene, self.from, direction, surfaces, self.to, λ, counters);
        let mut bent = bend(direction)?;
        for _ in 0..CORRECTIONS {
            let (step, spread) = bent.correction()?;
            let miss = bent.missed();
            if miss <= MET * self.distance {
                return Some(Link {
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
