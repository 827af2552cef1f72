//! Sources that light paths find.
//!
//! Where a lamp shines at a wall, most of a room's light comes from a spot that few camera paths meet. So
//! each group of pixels has light paths of its own. Every matte point that they come to is one more source
//! for all its receivers, and one end of connections with sources of camera paths; see [`super::rivals`] for
//! the weights.

use super::light_path::LightPath;
use super::rivals::{MOST_EDGES, Rivals};
use super::shared::Source;
use crate::emitter::{EmitterPoint, Emitters};
use crate::integrator::Counters;
use crate::integrator::caustics::Emission;
use crate::integrator::caustics::Landing;
use crate::integrator::wavefront::{Arrived, STREAM, Wavefront};
use crate::math::{DVec3, Ray};
use crate::sampler::{ManyNumbers, PAIRS, Sampler};
use crate::scene::{Scene, Shape};
use crate::spectrum::{Spectrum, Wavelengths};

/// The light paths for groups of pixels: how they start, and how many there are.
#[derive(Debug)]
pub struct LightSources {
    pub emission: Emission,
    /// M, the number of light paths per group and sample.
    pub paths: u32,
}

/// Whose light path has found a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Owner {
    /// The group that it is for.
    pub group: usize,
    /// The number of the light path there.
    pub light_path: u32,
}

/// A source that a light path has found.
#[derive(Debug)]
pub struct LightSource {
    pub owner: Owner,
    pub source: Source,
    /// Edges of the light path from the emitter to the source.
    pub edges: u32,
    /// Radiance that leaves the source, as one of M light paths estimates it, without the factor `scale`.
    pub radiance: Spectrum,
    pub scale: f64,
    pub rivals: Rivals,
}

impl LightSources {
    /// `None` without area emitters.
    pub fn new(paths: u32, shapes: &[Shape], emitters: &Emitters) -> Option<Self> {
        Some(Self { emission: Emission::everywhere(emitters, shapes)?, paths })
    }

    /// The factor of c at vₙ, where w is the direction back to vₙ₋₁.
    pub fn ratio_at_emitter(&self, scene: &Scene, end: EmitterPoint, w: DVec3) -> f64 {
        f64::from(self.paths) * self.emission.density_over_cos(scene, end, w)
    }

    /// Finds the sources of groups, for each of which a sampler and the wavelengths are given, in the order
    /// of the groups and of their light paths.
    pub fn find(
        &self,
        scene: &Scene,
        groups: impl Iterator<Item = (Sampler, Wavelengths)>,
        found: &mut Vec<LightSource>,
        counters: &mut Counters,
    ) {
        found.clear();
        let begun = |(group, (sampler, λ)): (usize, (Sampler, Wavelengths))| {
            (0..self.paths).filter_map(move |light_path| {
                LightPath::begin(self, scene, Owner { group, light_path }, sampler, λ)
            })
        };
        let mut all: Vec<(LightPath, Ray)> = groups.enumerate().flat_map(begun).collect();
        let mut numbers = ManyNumbers::<STREAM>::default();
        let mut wavefront = Wavefront::default();
        for paths in all.chunks_mut(STREAM) {
            wavefront.begin(paths.iter().map(|(_, ray)| *ray).enumerate());
            for edges in 1..=MOST_EDGES {
                let going = wavefront.trace(scene, counters);
                if going.is_empty() {
                    break;
                }
                numbers.fill(going.len(), PAIRS, |i| paths[going[i]].0.numbers(edges));
                wavefront.advance(|Arrived { place, path, ray, hit }| {
                    let landing = Landing { ray, hit: hit?, edges, u: numbers.of(place) };
                    paths[path].0.step(self, scene, landing, found)
                });
            }
        }
        found.sort_by_key(|source| source.owner);
        counters.light_sources += found.len() as u64;
    }
}
