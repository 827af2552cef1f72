//! Specular chains of paths between two rough surfaces, as far as links might follow them too.

use crate::bsdf::Sample;
use crate::math::DVec3;
use crate::scene::Side;

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
#[derive(Clone, Copy, Debug)]
pub struct SpecularChain {
    pub surfaces: u32,
    /// The probability of the lobes that were chosen along it.
    pub chance: f64,
    /// How many of them have reflected; all others let it through.
    pub reflections: u32,
    /// The primitive that has reflected last.
    pub mirror: Option<u32>,
    /// The primitive, if all surfaces are one and the same.
    alone: Option<u32>,
}

impl SpecularChain {
    /// Without any surface yet.
    pub const BEGUN: Self = Self { surfaces: 0, chance: 1.0, reflections: 0, mirror: None, alone: None };

    /// The chain with another surface, at which this was sampled; `None` if no link has such a chain.
    pub fn on(self, side: &Side, primitive: u32, wo: DVec3, sample: &Sample) -> Option<Self> {
        let with = self.with(turn(side, wo, sample)?, primitive);
        let with = Self { chance: self.chance * sample.pdf, ..with };
        Some(with).filter(|with| with.reflections < 2 || with.alone.is_some())
    }

    /// With one more surface.
    pub fn with(self, turn: Turn, primitive: u32) -> Self {
        let (reflections, mirror) = match turn {
            Turn::Through => (self.reflections, self.mirror),
            Turn::Back => (self.reflections + 1, Some(primitive)),
        };
        let alone = Some(primitive).filter(|_| self.surfaces == 0 || self.alone == Some(primitive));
        Self { surfaces: self.surfaces + 1, reflections, mirror, alone, ..self }
    }

    /// Whether it enters this primitive, is reflected `inner` times within it, leaves it, and meets nothing
    /// else.
    pub fn is_through(&self, primitive: u32, inner: u32) -> bool {
        self.alone == Some(primitive) && self.reflections == inner && self.surfaces == inner + 2
    }
}
