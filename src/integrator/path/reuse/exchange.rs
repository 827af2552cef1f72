//! Distribution of the light of a group's sources among its receivers.

use super::connections::Connections;
use super::light_sources::Lit;
use super::lobes::{At, Lobed};
use super::part::{Light, Part};
use super::questions::Questions;
use super::receivers::Receivers;
use super::rivals::Contested;
use super::shared::{Shared, Source};
use crate::integrator::{CameraPath, Counters};
use crate::math::bits;
use crate::scene::Scene;

/// Buffers for the distribution, kept for the next stream.
#[derive(Default)]
pub struct Exchange {
    receivers: Receivers,
    parts: Vec<(usize, Part)>,
    questions: Questions,
    lit: Vec<Lit>,
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
        let lit = std::mem::take(&mut self.lit);
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
                    let offer = Offer { source, light, own: Some(j), receivers: self.receivers.like(j) };
                    self.propose(scene, receiving, group, offer);
                }
            }
            for lit in of_group(&lit, number) {
                for kind in 0..self.receivers.kinds() {
                    let (edges, receivers) = self.receivers.of_kind(kind);
                    if edges + 2 + lit.edges <= max_depth {
                        let light = Light::ByLight(lit.radiance, lit.scale, lit.rivals);
                        let offer = Offer { source: &lit.source, light, own: None, receivers };
                        self.propose(scene, receiving, group, offer);
                    }
                }
            }
            first += shared.len();
        }
        self.lit = lit;
        self.questions.settle(scene, paths, shared, contested, counters);
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
        light_sources.find(scene, groups().map(|of| (of[0].sampler, of[0].λ)), &mut self.lit, counters);
        let mut first = 0;
        for (number, size) in groups().map(<[_]>::len).enumerate() {
            let group = &shared[first..first + size];
            let lit = of_group(&self.lit, number);
            self.connections.propose(light_sources, max_depth, first, group, lit);
            first += size;
        }
        self.connections.settle(scene, contested, counters);
        // Each path's own are in order already, and stay so.
        contested.sort_by_key(|of| of.path);
    }

    /// Gives each receiver that faces a source its share: at once if all of them are known to see it, else
    /// once the shadow rays have been traced.
    fn propose(&mut self, scene: &Scene, receiving: &mut [CameraPath], group: PathGroup, offer: Offer) {
        let Self { receivers, parts, questions, .. } = self;
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
            let parts =
                bits::numbers(facing | own).filter_map(|i| Some((i, Part::matte(weight(i)?, weights[i]))));
            questions.offer(receiving, group, offer, in_sight, true, parts);
        } else {
            rough_parts(scene, group, &offer, facing, &weights, parts);
            questions.offer(receiving, group, offer, in_sight, false, parts.iter().copied());
        }
    }
}

/// The parts of a source, where it or a receiver is rough.
fn rough_parts(
    scene: &Scene,
    PathGroup { shared, lobed, .. }: PathGroup,
    Offer { source, own, .. }: &Offer,
    facing: u64,
    weights: &[f64; 64],
    parts: &mut Vec<(usize, Part)>,
) {
    let onward = source.lobes.as_ref().map(|lobes| At::new(scene, lobes, lobed.λ));
    let part = |i: usize| {
        let receiver = shared[i].receiver.as_ref()?;
        let mut part = match lobed.at(i) {
            None => Part::matte(receiver.weight, weights[i]),
            Some(at) => at.receives(receiver, source),
        };
        if let Some(onward) = &onward {
            onward.sends(receiver, source, &mut part);
        }
        (part.density > 0.0 && part.density.is_finite()).then_some((i, part))
    };
    parts.clear();
    parts.extend(bits::numbers(facing).filter_map(part));
    if let Some(j) = own.filter(|j| parts.iter().all(|(i, _)| i != j)) {
        parts.push((j, Part::matte(shared[j].own, f64::MIN_POSITIVE)));
    }
}

/// The sources that light paths have found for a group, by its number.
fn of_group(lit: &[Lit], number: usize) -> &[Lit] {
    let begin = lit.partition_point(|lit| lit.owner.0 < number);
    let end = lit.partition_point(|lit| lit.owner.0 <= number);
    &lit[begin..end]
}
