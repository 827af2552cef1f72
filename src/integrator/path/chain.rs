//! What a camera path must know of its last vertex with emitter samples by specular chains, to weigh an emitter that
//! it meets at the end of such a chain.

use crate::bsdf::Sample;
use crate::emitter::EmitterPoint;
use crate::integrator::Counters;
use crate::integrator::guide::{Directions, LONGEST_CHAIN};
use crate::integrator::links::{SpecularChain, density_of};
use crate::math::{DVec3, Origin};
use crate::scene::{Scene, Side};
use crate::spectrum::Wavelengths;

/// The specular chain of a path since it left a vertex that takes emitter samples by links or a guide.
#[derive(Clone, Copy, Debug)]
pub enum ChainSince {
    /// No such vertex, or no such sample makes the chain.
    Nothing,
    /// A vertex that takes emitter samples by links.
    Linked {
        from: Origin,
        /// The direction in which the path left it (world).
        direction: DVec3,
        /// The density of the direction, times the probabilities of the lobes chosen since.
        pdf: f64,
        chain: SpecularChain,
    },
    /// A vertex that takes guided emitter samples.
    Guided {
        /// The density of such a sample in the path's direction over that of scattering. The probabilities of the
        /// lobes along the chain are the same for both.
        density_ratio: f64,
        /// How many surfaces such a sample would still follow.
        surfaces_left: u32,
    },
}

impl ChainSince {
    /// Leaves a vertex with such samples in a sampled direction (world); `seen` is what guides them, if anything
    /// does.
    pub fn begin(from: Origin, direction: DVec3, sample: &Sample, seen: Option<&Directions>) -> Self {
        match seen {
            _ if sample.delta => Self::Nothing,
            None => Self::Linked { from, direction, pdf: sample.pdf, chain: SpecularChain::BEGUN },
            Some(seen) => Self::Guided {
                density_ratio: seen.density(direction) / sample.pdf,
                surfaces_left: LONGEST_CHAIN,
            },
        }
    }

    /// Goes on from a vertex without emitter samples.
    pub fn follow(&mut self, wo: DVec3, side: &Side, primitive: u32, sample: &Sample) {
        *self = match *self {
            Self::Linked { from, direction, pdf, chain } => match chain.on(side, primitive, wo, sample) {
                Some(chain) => Self::Linked { from, direction, pdf: pdf * sample.pdf, chain },
                None => Self::Nothing,
            },
            Self::Guided { density_ratio, surfaces_left: left @ 1.. } if !sample.dispersed => {
                Self::Guided { density_ratio, surfaces_left: left - 1 }
            }
            _ => Self::Nothing,
        };
    }

    /// The density of emitter samples over that of scattering, for the path that has met a point of an emitter;
    /// there are `count` samples, or one if it is guided.
    pub fn emitter_density_ratio(
        &self,
        scene: &Scene,
        end: EmitterPoint,
        count: f64,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> f64 {
        match *self {
            Self::Linked { from, direction, pdf, chain } if chain.surfaces > 0 => {
                let found = density_of(scene, from, direction, chain, end, λ, counters);
                found.map_or(0.0, |found| found * count / pdf)
            }
            Self::Guided { density_ratio, .. } => density_ratio,
            _ => 0.0,
        }
    }
}
