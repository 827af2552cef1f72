//! Distribution of the light of a group's sources among its receivers.

use super::connections::Connections;
use super::contribution::{Contribution, Light};
use super::light_sources::LightSource;
use super::lobes::{At, Lobed};
use super::pending::PendingContributions;
use super::receivers::{EdgeClass, Receivers};
use super::rivals::Contested;
use super::shared::{Shared, Source};
use crate::integrator::{CameraPath, Counters};
use crate::math::bits;
use crate::scene::Scene;

/// Buffers for the distribution, kept for the next stream.
#[derive(Default)]
pub struct Exchange {
    receivers: Receivers,
    contributions: Vec<(usize, Contribution)>,
    pending: PendingContributions,
    found: Vec<LightSource>,
    connections: Connections,
}

/// A group of paths.
#[derive(Clone, Copy)]
pub struct PathGroup<'a> {
    /// The number of its first path.
    pub first: usize,
    pub shared: &'a [Shared],
    /// Contested light of all groups.
    pub contested: &'a [Contested],
    lobed: &'a Lobed<'a>,
}

/// A source's light, and which of a group's receivers it is for: a bit for each.
pub struct Offer<'a> {
    pub source: &'a Source,
    pub light: Light,
    /// Number in the group of the path that found it; `None` for a light path.
    own: Option<usize>,
    receivers: u64,
}

impl Exchange {
    /// Distributes what every path found to all receivers that see its source, and the light of the sources
    /// of light paths likewise. Contested light must be in the order of the paths, each path's in the order
    /// in which it found it.
    pub fn share(
        &mut self,
        scene: &Scene,
        max_depth: u32,
        paths: &mut [CameraPath],
        shared: &[Shared],
        contested: &mut Vec<Contested>,
        counters: &mut Counters,
    ) {
        self.find(scene, max_depth, paths, shared, contested, counters);
        let found = std::mem::take(&mut self.found);
        let (mut first, mut contested_before) = (0, 0);
        for (number, receiving) in paths.chunk_by_mut(|a, b| a.group == b.group).enumerate() {
            let shared = &shared[first..first + receiving.len()];
            self.receivers.begin(shared);
            // Path 0 may have lost lanes since, but rough BSDFs do not depend on which are alive.
            let λ = receiving[0].λ;
            let group = PathGroup { first, shared, contested, lobed: &Lobed::new(scene, shared, &λ) };
            for (j, path) in shared.iter().enumerate() {
                let own = contested[contested_before..].iter().take_while(|of| of.path == first + j).count();
                let range = contested_before..contested_before + own;
                contested_before = range.end;
                let has_light = !path.radiance.is_zero() || own > 0;
                if let Some(source) = path.source.as_ref().filter(|_| has_light) {
                    let light = Light::ByCamera(path.radiance, range);
                    let offer =
                        Offer { source, light, own: Some(j), receivers: self.receivers.with_edges_of(j) };
                    self.propose(scene, receiving, group, offer);
                }
            }
            for source in of_group(&found, number) {
                for class in 0..self.receivers.classes().len() {
                    let EdgeClass { edges, receivers } = self.receivers.classes()[class];
                    if edges + 2 + source.edges <= max_depth {
                        let light = Light::ByLight(source.radiance, source.scale, source.rivals);
                        let offer = Offer { source: &source.source, light, own: None, receivers };
                        self.propose(scene, receiving, group, offer);
                    }
                }
            }
            first += shared.len();
        }
        self.found = found;
        self.pending.resolve(scene, paths, shared, contested, counters);
        contested.clear();
    }

    /// Traces the light paths of all groups, and connects their sources with those of camera paths.
    fn find(
        &mut self,
        scene: &Scene,
        max_depth: u32,
        paths: &[CameraPath],
        shared: &[Shared],
        contested: &mut Vec<Contested>,
        counters: &mut Counters,
    ) {
        let Some(light_sources) = &scene.techniques.light_sources else { return };
        let groups = || paths.chunk_by(|a, b| a.group == b.group);
        light_sources.find(scene, groups().map(|of| (of[0].sampler, of[0].λ)), &mut self.found, counters);
        let mut first = 0;
        for (number, size) in groups().map(<[_]>::len).enumerate() {
            let group = &shared[first..first + size];
            let found = of_group(&self.found, number);
            self.connections.propose(light_sources, max_depth, first, group, found);
            first += size;
        }
        self.connections.resolve(scene, contested, counters);
        // Each path's own are in order already, and stay so.
        contested.sort_by_key(|of| of.path);
    }

    /// Gives each receiver that faces a source its share: at once if all of them are known to see it, else
    /// once the shadow rays have been traced.
    fn propose(&mut self, scene: &Scene, receiving: &mut [CameraPath], group: PathGroup, offer: Offer) {
        let Self { receivers, contributions, pending, .. } = self;
        let mut weights = [0.0; 64];
        let facing = receivers.weights(offer.receivers, offer.source, &mut weights);
        // A path knows of itself that it met its source, whatever rounding says.
        let own = offer.own.map_or(0, |j| 1 << j);
        if facing | own == 0 {
            return;
        }
        let in_sight = receivers.in_sight(scene, offer.source) | own;
        if group.lobed.is_empty() && offer.source.lobes.is_none() {
            if let Some(j) = offer.own.filter(|_| facing & own == 0) {
                weights[j] = f64::MIN_POSITIVE;
            }
            let weight = |i: usize| Some(group.shared[i].receiver.as_ref()?.weight);
            let contributions = bits::numbers(facing | own)
                .filter_map(|i| Some((i, Contribution::matte(weight(i)?, weights[i]))));
            pending.offer(receiving, group, offer, in_sight, true, contributions);
        } else {
            rough_parts(scene, group, &offer, facing, &weights, contributions);
            pending.offer(receiving, group, offer, in_sight, false, contributions.iter().copied());
        }
    }
}

/// The contributions of a source, where it or a receiver is rough.
fn rough_parts(
    scene: &Scene,
    PathGroup { shared, lobed, .. }: PathGroup,
    Offer { source, own, .. }: &Offer,
    facing: u64,
    weights: &[f64; 64],
    contributions: &mut Vec<(usize, Contribution)>,
) {
    let onward = source.lobes.as_ref().map(|lobes| At::new(scene, lobes, lobed.λ));
    let contribution = |i: usize| {
        let receiver = shared[i].receiver.as_ref()?;
        let mut contribution = match lobed.at(i) {
            None => Contribution::matte(receiver.weight, weights[i]),
            Some(at) => at.receives(receiver, source),
        };
        if let Some(onward) = &onward {
            onward.sends(receiver, source, &mut contribution);
        }
        Some((i, contribution))
    };
    contributions.clear();
    contributions.extend(bits::numbers(facing).filter_map(contribution));
    // A path may have gone on with a throughput that was not zero by rounding alone. It found nothing then, and the
    // densities of others, however small, are not those of its light.
    if contributions.iter().any(|(i, of)| Some(*i) == *own && of.weight.is_zero()) {
        contributions.clear();
        return;
    }
    // Where nothing of its throughput is left, a receiver's own path would have ended before it found anything: it
    // is none of the techniques.
    contributions.retain(|(_, of)| of.density > 0.0 && of.density.is_finite() && !of.weight.is_zero());
    if let Some(j) = own.filter(|j| contributions.iter().all(|(i, _)| i != j)) {
        contributions.push((j, Contribution::matte(shared[j].own, f64::MIN_POSITIVE)));
    }
}

/// The sources that light paths have found for a group, by its number.
fn of_group(found: &[LightSource], number: usize) -> &[LightSource] {
    let begin = found.partition_point(|source| source.owner.group < number);
    let end = found.partition_point(|source| source.owner.group <= number);
    &found[begin..end]
}
