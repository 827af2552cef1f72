//! Contributions that wait for shadow rays between receivers and sources.

use super::contribution::{Contribution, Light, distribute};
use super::exchange::{Offer, PathGroup};
use super::rivals::{Contested, MOST_EDGES};
use super::shared::{Shared, trace_shadow_rays};
use crate::integrator::wavefront::STREAM;
use crate::integrator::{CameraPath, Counters};
use crate::math::Ray;
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Shadow rays between receivers and sources, and the contributions that depend on them.
#[derive(Default)]
pub struct PendingContributions {
    rays: Vec<Ray>,
    waiting: Vec<PendingContribution>,
    /// Light of the sources that they are of.
    lights: Vec<Light>,
    /// [`Contribution::weight`] of those for which it is not the receiver's own.
    weights: Vec<Spectrum>,
    occluded: Vec<bool>,
}

/// What a receiver gets of a source that it sees; there are thousands at a time, so indices are small.
struct PendingContribution {
    light: u16,
    receiver: u8,
    is_seen: bool,
    /// Index of its weight among [`PendingContributions::weights`]; `None` if that is the receiver's own.
    weight: Option<u16>,
    geometry: f64,
    density: f64,
}

// A group has no more light paths than pixels, and each finds no more sources than it has edges.
const _: () =
    assert!(STREAM <= 1 << u8::BITS && STREAM * STREAM * (1 + MOST_EDGES as usize) <= 1 << u16::BITS);

impl PendingContribution {
    fn contribution(&self, shared: &[Shared], weights: &[Spectrum]) -> (usize, Contribution) {
        let receiver = usize::from(self.receiver);
        let of_receiver = || shared[receiver].receiver.as_ref().map_or(Spectrum::ZERO, |of| of.weight);
        let weight = self.weight.map_or_else(of_receiver, |place| weights[usize::from(place)]);
        (receiver, Contribution { weight, geometry: self.geometry, density: self.density })
    }
}

impl PendingContributions {
    /// Distributes the light at once if all receivers are known to see the source, else queues shadow rays to
    /// the others. `matte` is whether all contributions are those of [`Contribution::matte`].
    pub fn offer(
        &mut self,
        receiving: &mut [CameraPath],
        PathGroup { first, shared, contested, .. }: PathGroup,
        Offer { source, light, .. }: Offer,
        in_sight: u64,
        matte: bool,
        contributions: impl Iterator<Item = (usize, Contribution)> + Clone,
    ) {
        if contributions.clone().all(|(i, _)| in_sight >> i & 1 == 1) {
            distribute(receiving, &light, contested, contributions);
            return;
        }
        let number = self.lights.len() as u16;
        self.lights.push(light);
        for (i, Contribution { weight, geometry, density }) in contributions {
            let is_seen = in_sight >> i & 1 == 1;
            let Some(receiver) = shared[i].receiver.as_ref() else { continue };
            if !is_seen {
                self.rays.push(receiver.ray_to(source));
            }
            let place = (!matte).then_some(self.weights.len() as u16);
            self.weights.extend(place.map(|_| weight));
            let receiver = (first + i) as u8;
            self.waiting.push(PendingContribution {
                light: number,
                receiver,
                is_seen,
                weight: place,
                geometry,
                density,
            });
        }
    }

    /// Traces the shadow rays, distributes the light to receivers that see it, and empties the queue.
    pub fn resolve(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &[Shared],
        contested: &[Contested],
        counters: &mut Counters,
    ) {
        let Self { rays, waiting, lights, weights, occluded } = self;
        trace_shadow_rays(scene, rays, occluded, counters);
        let asked = waiting.iter_mut().filter(|one| !one.is_seen);
        asked.zip(occluded).for_each(|(one, occluded)| one.is_seen = !*occluded);
        for of_light in waiting.chunk_by(|a, b| a.light == b.light) {
            let seen = of_light.iter().filter(|one| one.is_seen);
            distribute(
                paths,
                &lights[usize::from(of_light[0].light)],
                contested,
                seen.map(|one| one.contribution(shared, weights)),
            );
        }
        rays.clear();
        waiting.clear();
        lights.clear();
        weights.clear();
    }
}
