//! The surfaces that a link leads by: those between its ends, or between the ends and a mirror.

use super::element::Element;
use crate::integrator::Counters;
use crate::math::{DVec3, Origin, Ray, length};
use crate::scene::{Scene, Shape};

/// Most surfaces of a link; longer chains are left to scattering.
const LONGEST_LINK: usize = 8;

/// A surface of a specular chain.
#[derive(Clone, Copy, Debug)]
pub enum Surface<'a> {
    /// Refracts; given by the first primitive of its shape.
    Glass(u32),
    Mirror(&'a Element),
}

/// Which end of a straight line lies on a mirror.
#[derive(Clone, Copy)]
pub enum End {
    First,
    Last,
}

/// The surfaces that a link is to lead by, in order.
pub struct Surfaces<'a> {
    all: [Surface<'a>; LONGEST_LINK],
    count: usize,
}

impl<'a> Surfaces<'a> {
    pub fn none() -> Self {
        Self { all: [Surface::Glass(0); LONGEST_LINK], count: 0 }
    }

    pub fn list(&self) -> &[Surface<'a>] {
        &self.all[..self.count]
    }

    /// Adds one; `None` if there are too many.
    pub fn push(&mut self, surface: Surface<'a>) -> Option<()> {
        *self.all.get_mut(self.count)? = surface;
        self.count += 1;
        Some(())
    }

    /// Whether they are those of a ball of glass, in and out: there may be several such links, and another technique
    /// finds all of them.
    pub fn are_glass_ball(&self, scene: &Scene) -> bool {
        match *self.list() {
            [Surface::Glass(a), Surface::Glass(b)] if a == b => {
                scene.techniques.links.as_ref().is_some_and(|links| links.glass_balls.have(a))
            }
            _ => false,
        }
    }

    /// Adds the shapes that the straight line goes through, up to the mirror if it leads there; `None` if one
    /// of them does not refract.
    pub fn read(
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

/// The shape of a primitive, and its number there, if a link may lead by it.
pub fn specular(scene: &Scene, primitive: u32) -> Option<(&Shape, u32)> {
    if scene.instances.have(primitive) {
        return None;
    }
    let (shape, local) = scene.shape_of(primitive);
    (shape.refracts() || shape.mirrors()).then_some((shape, local))
}
