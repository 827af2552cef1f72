//! Shadow rays between receivers and sources.

use super::exchange::{Offer, PathGroup};
use super::part::{Light, Part, hand_on};
use super::rivals::{Contested, MOST_EDGES};
use super::shared::{Shared, ask};
use crate::integrator::wavefront::STREAM;
use crate::integrator::{CameraPath, Counters};
use crate::math::Ray;
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Shadow rays between receivers and sources, and the shares that depend on them.
#[derive(Default)]
pub struct Questions {
    rays: Vec<Ray>,
    shares: Vec<Share>,
    /// Light of the sources that have shares.
    lights: Vec<Light>,
    /// [`Part::weight`] of the shares for which it is not the receiver's own.
    weights: Vec<Spectrum>,
    occluded: Vec<bool>,
}

/// What a receiver gets of a source that it sees; there are thousands at a time, so indices are small.
struct Share {
    light: u16,
    receiver: u8,
    is_seen: bool,
    /// Index of its weight among [`Questions::weights`]; `None` if that is the receiver's own.
    weight: Option<u16>,
    geometry: f64,
    density: f64,
}

// A group has no more light paths than pixels, and each finds no more sources than it has edges.
const _: () =
    assert!(STREAM <= 1 << u8::BITS && STREAM * STREAM * (1 + MOST_EDGES as usize) <= 1 << u16::BITS);

impl Share {
    fn part(&self, shared: &[Shared], weights: &[Spectrum]) -> (usize, Part) {
        let receiver = usize::from(self.receiver);
        let of_receiver = || shared[receiver].receiver.as_ref().map_or(Spectrum::ZERO, |of| of.weight);
        let weight = self.weight.map_or_else(of_receiver, |place| weights[usize::from(place)]);
        (receiver, Part { weight, geometry: self.geometry, density: self.density })
    }
}

impl Questions {
    /// Distributes the light at once if all receivers are known to see the source, else queues shadow rays to
    /// the others. `matte` is whether all parts are those of [`Part::matte`].
    pub fn offer(
        &mut self,
        receiving: &mut [CameraPath],
        PathGroup { first, shared, contested, .. }: PathGroup,
        Offer { source, light, .. }: Offer,
        in_sight: u64,
        matte: bool,
        parts: impl Iterator<Item = (usize, Part)> + Clone,
    ) {
        if parts.clone().all(|(i, _)| in_sight >> i & 1 == 1) {
            hand_on(receiving, &light, contested, parts);
            return;
        }
        let number = self.lights.len() as u16;
        self.lights.push(light);
        for (i, Part { weight, geometry, density }) in parts {
            let is_seen = in_sight >> i & 1 == 1;
            let Some(receiver) = shared[i].receiver.as_ref() else { continue };
            if !is_seen {
                self.rays.push(receiver.ray_to(source));
            }
            let place = (!matte).then_some(self.weights.len() as u16);
            self.weights.extend(place.map(|_| weight));
            let receiver = (first + i) as u8;
            self.shares.push(Share { light: number, receiver, is_seen, weight: place, geometry, density });
        }
    }

    /// Traces the shadow rays, distributes the light to receivers that see it, and empties the queue.
    pub fn settle(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &[Shared],
        contested: &[Contested],
        counters: &mut Counters,
    ) {
        let Self { rays, shares, lights, weights, occluded } = self;
        ask(scene, rays, occluded, counters);
        let asked = shares.iter_mut().filter(|share| !share.is_seen);
        asked.zip(occluded).for_each(|(share, occluded)| share.is_seen = !*occluded);
        for shares in shares.chunk_by(|a, b| a.light == b.light) {
            let seen = shares.iter().filter(|share| share.is_seen);
            hand_on(
                paths,
                &lights[usize::from(shares[0].light)],
                contested,
                seen.map(|share| share.part(shared, weights)),
            );
        }
        rays.clear();
        shares.clear();
        lights.clear();
        weights.clear();
    }
}
