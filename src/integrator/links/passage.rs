//! Specular chains of paths between two rough surfaces, as far as links might follow them too.

use super::density_of;
use crate::bsdf::Sample;
use crate::emitter::EmitterPoint;
use crate::integrator::Counters;
use crate::integrator::guide::{Directions, MOST_SURFACES};
use crate::math::{DVec3, Origin};
use crate::scene::{Scene, Side};
use crate::spectrum::Wavelengths;

/// What a lobe without density does with light, all wavelengths alike: it transmits or reflects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    Through,
    Back,
}

/// What a side did to light when it was sampled for ωo, if a link can do that.
pub fn turn(side: &Side, wo: DVec3, sample: &Sample) -> Option<Turn> {
    let turn = if wo.z * sample.wi.z < 0.0 { Turn::Through } else { Turn::Back };
    let can = match turn {
        Turn::Through => side.traits.refracts,
        Turn::Back => side.traits.mirrors,
    };
    (can && !side.traits.irreversible && sample.delta && !sample.dispersed).then_some(turn)
}

/// A specular chain between two vertices that scatter with a density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passage {
    pub surfaces: u32,
    /// How many of them have reflected; all others let it through.
    pub reflections: u32,
    /// The primitive that has reflected last.
    pub mirror: Option<u32>,
    /// The primitive, if all surfaces are one and the same.
    alone: Option<u32>,
}

impl Passage {
    /// The chain with another surface; `None` if no link has such a chain.
    pub fn on(self, side: &Side, primitive: u32, wo: DVec3, sample: &Sample) -> Option<Self> {
        Some(self.with(turn(side, wo, sample)?, primitive))
            .filter(|with| with.reflections < 2 || with.alone.is_some())
    }

    /// With one more surface.
    pub fn with(self, turn: Turn, primitive: u32) -> Self {
        let (reflections, mirror) = match turn {
            Turn::Through => (self.reflections, self.mirror),
            Turn::Back => (self.reflections + 1, Some(primitive)),
        };
        let alone = Some(primitive).filter(|_| self.surfaces == 0 || self.alone == Some(primitive));
        Self { surfaces: self.surfaces + 1, reflections, mirror, alone }
    }

    /// Whether it enters this primitive, is reflected `inner` times within it, leaves it, and meets nothing
    /// else.
    pub fn is_through(&self, primitive: u32, inner: u32) -> bool {
        self.alone == Some(primitive) && self.reflections == inner && self.surfaces == inner + 2
    }
}

/// The specular chain of a path since it left a vertex that takes emitter samples by links or a guide.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    from: Origin,
    direction: DVec3,
    /// The density of the direction, times the probabilities of the lobes chosen since.
    pdf: f64,
    /// `None` if there is no such vertex, or if no link has such a chain.
    passage: Option<Passage>,
    /// Density of a guided emitter sample by the same chain over that of scattering, and how many surfaces it
    /// may still lead by.
    guided: (f64, u32),
}

impl Way {
    pub const NONE: Self = Self {
        from: Origin { p: DVec3::ZERO, primitive: 0 },
        direction: DVec3::ZERO,
        pdf: 0.0,
        passage: None,
        guided: (0.0, 0),
    };

    /// Leaves a vertex in a sampled direction (world); `seen` is what guides its emitter samples, if anything
    /// does.
    pub fn begin(from: Origin, direction: DVec3, sample: &Sample, seen: Option<&Directions>) -> Self {
        let passage = (!sample.delta && seen.is_none()).then_some(Passage::default());
        let seen = seen.filter(|_| !sample.delta);
        let guided = seen.map_or(0.0, |seen| seen.density(direction) / sample.pdf);
        Self { from, direction, pdf: sample.pdf, passage, guided: (guided, MOST_SURFACES) }
    }

    /// Goes on from a vertex without emitter samples.
    pub fn follow(&mut self, wo: DVec3, side: &Side, primitive: u32, sample: &Sample) {
        self.passage = self.passage.and_then(|passage| passage.on(side, primitive, wo, sample));
        self.pdf *= sample.pdf;
        self.guided = match self.guided {
            (likelier, surfaces @ 1..) if !sample.dispersed => (likelier, surfaces - 1),
            _ => (0.0, 0),
        };
    }

    /// Density of emitter samples over that of scattering, for the path that has met a point of an emitter;
    /// there are `count` samples, or one if it is guided.
    pub fn rival(
        &self,
        scene: &Scene,
        end: EmitterPoint,
        count: f64,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> f64 {
        let Some(passage) = self.passage.filter(|passage| passage.surfaces > 0) else { return self.guided.0 };
        let found = density_of(scene, self.from, self.direction, passage, end, λ, counters);
        found.map_or(0.0, |pdf| pdf * count / self.pdf)
    }
}
