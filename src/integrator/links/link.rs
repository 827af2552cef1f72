//! A link: a specular chain from one point to another, through refracting interfaces and perhaps by a mirror.
//!
//! The interfaces are those on the straight line between the two points, or on the lines by which the first
//! sees the second in the mirror. Then a ray is traced and bent at each of them, and its direction is
//! corrected until it meets the other point: Newton's method in two unknowns, whose derivatives the ray
//! carries along ([`bent`](super::bent)).

use super::SAME;
use super::bent::Bent;
use super::element::Element;
use super::glass_ball::Starts;
use super::surfaces::{End, Surface, Surfaces};
use crate::integrator::Counters;
use crate::math::frame::unit;
use crate::math::ray::position_error;
use crate::math::{DVec3, Frame, Origin, Ray, length};
use crate::scene::Scene;
use crate::spectrum::{Spectrum, Wavelengths};

/// Most Newton steps; the fourth is seldom needed.
const CORRECTIONS: usize = 12;

/// Lengths that are tried for a Newton step, each half of the one before, until one reduces the miss.
const HALVINGS: usize = 6;

/// A ray has met a point if it misses it by no more than this fraction of the link's length.
const MET: f64 = 1.0 / (1u64 << 26) as f64;

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

/// A search for links by given surfaces to a point, one from each of some start directions.
pub struct Search<'a> {
    scene: &'a Scene,
    from: Origin,
    to: DVec3,
    surfaces: Surfaces<'a>,
    starts: Starts,
    /// Whether the start directions are those of the links already, and not only near them.
    exact: bool,
    /// Approximate length of the links.
    distance: f64,
}

/// Whether two points are farther apart than both are known.
fn apart(a: DVec3, b: DVec3) -> bool {
    length(a - b) > position_error(a) + position_error(b)
}

impl<'a> Search<'a> {
    /// For links from a point on a primitive to another point, by a mirror or a ball of glass if one is given; `None`
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
        let mut surfaces = Surfaces::none();
        let mut glass_ball = None;
        let first = match by {
            None => {
                surfaces.read(scene, from, to, None, counters)?;
                if surfaces.are_glass_ball(scene) {
                    return None;
                }
                to
            }
            Some(element) => match element.glass_ball() {
                Some(found) => {
                    let glass = Surface::Glass(element.primitives[0]);
                    surfaces.push(glass)?;
                    (0..found.inner).try_for_each(|_| surfaces.push(Surface::Mirror(element)))?;
                    surfaces.push(glass)?;
                    glass_ball = Some(found);
                    found.ball.centre
                }
                None => {
                    let seen = element.reflection(from.p, to)?;
                    // What lies in a mirror's plane, as the tiles of a chessboard do, is before it or behind it by
                    // rounding alone, and would be seen at its own place, in no direction.
                    if !(apart(from.p, seen) && apart(to, seen)) {
                        return None;
                    }
                    surfaces.read(scene, from, seen, Some((element, End::Last)), counters)?;
                    surfaces.push(Surface::Mirror(element))?;
                    let mirrored = Origin { p: seen, primitive: element.primitives[0] };
                    surfaces.read(scene, mirrored, to, Some((element, End::First)), counters)?;
                    seen
                }
            },
        };
        if !(1..=most).contains(&surfaces.list().len()) {
            return None;
        }
        let starts = match glass_ball {
            Some(glass_ball) => glass_ball.ways(from.p, to),
            None => Starts::one(unit(first - from.p)),
        };
        let distance = length(first - from.p) + length(to - first);
        Some(Self { scene, from, to, surfaces, starts, exact: glass_ball.is_some(), distance })
    }

    /// How many surfaces a link leads by.
    pub fn surfaces(&self) -> u32 {
        self.surfaces.list().len() as u32
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
        let surfaces = self.surfaces.list();
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
