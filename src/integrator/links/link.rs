//! A link: a specular chain from one point to another, through refracting interfaces and perhaps by a mirror.
//!
//! The interfaces are those on the straight line between the two points, or on the lines by which the first
//! sees the second in the mirror. Then a ray is traced and bent at each of them, and its direction is
//! corrected until it meets the other point: Newton's method in two unknowns, whose derivatives the ray
//! carries along ([`bent`](super::bent)).

use super::SAME;
use super::bent::{Bent, specular};
use super::element::Element;
use super::lens::Starts;
use crate::integrator::Counters;
use crate::math::frame::unit;
use crate::math::{DVec3, Frame, Origin, Ray, length};
use crate::scene::Scene;
use crate::spectrum::{Spectrum, Wavelengths};

/// Most surfaces of a link; longer chains are left to scattering.
const LONGEST_LINK: usize = 8;

/// Most Newton steps; the fourth is seldom needed.
const CORRECTIONS: usize = 12;

/// Lengths that are tried for a Newton step, each half of the one before, until one reduces the miss.
const HALVINGS: usize = 6;

/// A ray has met a point if it misses it by no more than this fraction of the link's length.
const MET: f64 = 1.0 / (1u64 << 26) as f64;

/// A surface of a specular chain.
#[derive(Clone, Copy, Debug)]
pub enum Surface<'a> {
    /// Refracts; given by the first primitive of its shape.
    Glass(u32),
    Mirror(&'a Element),
}

/// A path between two points by surfaces that refract or reflect.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Unit direction in which it leaves the first point.
    pub direction: DVec3,
    pub surfaces: u32,
    /// Factor of radiance that comes along it to the first point.
    pub transmittance: Spectrum,
    /// Probability with which a scattered path chooses the same lobes along it.
    pub chance: f64,
    /// The square of the index at the second point over that at the first.
    pub eta2: f64,
    /// Area across the ray at the second point for each unit of solid angle at the first.
    pub spread: f64,
    /// Ray from the last surface to where it is nearest to the second point.
    pub last: Ray,
    /// Distance by which that ray misses the second point.
    pub miss: f64,
}

/// Which end of a straight line lies on a mirror.
#[derive(Clone, Copy)]
enum End {
    First,
    Last,
}

/// The surfaces of a specular chain that is being collected.
struct Chain<'a> {
    surfaces: [Surface<'a>; LONGEST_LINK],
    count: usize,
}

impl<'a> Chain<'a> {
    fn push(&mut self, surface: Surface<'a>) -> Option<()> {
        *self.surfaces.get_mut(self.count)? = surface;
        self.count += 1;
        Some(())
    }

    /// Whether it leads through a lens, in and out: there may be several such links, and another technique
    /// finds all of them.
    fn is_lens(&self, scene: &Scene) -> bool {
        match self.surfaces[..self.count] {
            [Surface::Glass(a), Surface::Glass(b)] if a == b => {
                scene.techniques.links.as_ref().is_some_and(|links| links.lenses.have(a))
            }
            _ => false,
        }
    }

    /// Adds the shapes that the straight line goes through, up to the mirror if it leads there; `None` if one
    /// of them does not refract.
    fn read(
        &mut self,
        scene: &Scene,
        Origin { mut p, mut primitive }: Origin,
        to: DVec3,
        mirror: Option<(&Element, End)>,
        counters: &mut Counters,
    ) -> Option<()> {
        let mut distance = length(to - p);
        let straight = (to - p) / distance;
        if !scene.techniques.links.as_ref()?.may_be_between(p, straight, distance) {
            return Some(());
        }
        loop {
            let ray = Ray::leaving(p, straight, distance, primitive);
            counters.rays += 1;
            let Some(hit) = scene.accel.closest(&ray) else { return Some(()) };
            match mirror.filter(|(mirror, _)| mirror.has(hit.primitive)) {
                Some((_, End::Last)) => return Some(()),
                // Another piece of it: all lie in one plane but for the rounding of their corners.
                Some((_, End::First)) => {}
                None => {
                    let (shape, _) = specular(scene, hit.primitive).filter(|(shape, _)| shape.refracts())?;
                    self.push(Surface::Glass(shape.first_primitive))?;
                }
            }
            (p, primitive, distance) = (ray.at(hit.t), hit.primitive, distance - hit.t);
        }
    }
}

/// A search for links by given surfaces to a point, one from each of some start directions.
pub struct Search<'a> {
    scene: &'a Scene,
    from: Origin,
    to: DVec3,
    chain: Chain<'a>,
    starts: Starts,
    /// Whether the start directions are those of the links already, and not only near them.
    exact: bool,
    /// Approximate length of the links.
    distance: f64,
}

impl<'a> Search<'a> {
    /// For links from a point on a primitive to another point, by a mirror or a lens if one is given; `None`
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
        let mut chain = Chain { surfaces: [Surface::Glass(0); LONGEST_LINK], count: 0 };
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
                    chain.read(scene, from, seen, Some((element, End::Last)), counters)?;
                    chain.push(Surface::Mirror(element))?;
                    let mirrored = Origin { p: seen, primitive: element.primitives[0] };
                    chain.read(scene, mirrored, to, Some((element, End::First)), counters)?;
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

    /// How many surfaces a link leads by.
    pub fn surfaces(&self) -> u32 {
        self.chain.count as u32
    }

    /// The links that are found.
    pub fn links<'s>(
        &'s self,
        λ: &'s Wavelengths,
        counters: &'s mut Counters,
    ) -> impl Iterator<Item = Link> + 's {
        self.starts.list().iter().filter_map(move |start| {
            // Newton's method must not lead to the link of another start.
            let link = self.link(*start, λ, counters)?;
            (!self.exact || length(link.direction - *start) < SAME).then_some(link)
        })
    }

    /// The link to which Newton's method converges from a direction.
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
