//! Which receivers see a source.

use super::part::{Part, hand_on};
use super::shared::{Shared, Source};
use super::stream::STREAM;
use crate::integrator::{CameraPath, Counters};
use crate::math::ray::{Ends, way_between};
use crate::math::{Ray, length};
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Rays between receivers and sources.
#[derive(Default)]
pub struct Questions {
    rays: Vec<Ray>,
    shares: Vec<Share>,
    /// [`Part::weight`] of the shares that have another than their receivers.
    weights: Vec<Spectrum>,
    occluded: Vec<bool>,
}

/// What a receiver may have of a source; there are thousands at a time, so their numbers are small.
struct Share {
    source: u8,
    receiver: u8,
    is_seen: bool,
    /// Its place among the weights, if it is not that of the receiver.
    weight: Option<u16>,
    geometry: f64,
    density: f64,
}

const _: () = assert!(STREAM <= 1 << u8::BITS && STREAM * STREAM <= 1 << u16::BITS);

impl Share {
    fn part(&self, shared: &[Shared], weights: &[Spectrum]) -> (usize, Part) {
        let receiver = usize::from(self.receiver);
        let of_receiver = || shared[receiver].receiver.as_ref().map_or(Spectrum::ZERO, |of| of.weight);
        let weight = self.weight.map_or_else(of_receiver, |place| weights[usize::from(place)]);
        (receiver, Part { weight, geometry: self.geometry, density: self.density })
    }
}

impl Questions {
    /// Hands parts on at once if all receivers are known to see the source, else asks about the others first. All parts are matte or not.
    pub fn offer(
        &mut self,
        receiving: &mut [CameraPath],
        group: &[Shared],
        (first, j, source): (usize, usize, &Source),
        (in_sight, matte): (u64, bool),
        parts: impl Iterator<Item = (usize, Part)> + Clone,
    ) {
        if parts.clone().all(|(i, _)| in_sight >> i & 1 == 1) {
            hand_on(receiving, group[j].radiance, parts);
            return;
        }
        for (i, Part { weight, geometry, density }) in parts {
            let is_seen = in_sight >> i & 1 == 1;
            let Some(receiver) = group[i].receiver.as_ref() else { continue };
            if !is_seen {
                let way = source.p - receiver.p;
                let distance = length(way);
                let end = way_between(distance, receiver.p, source.p);
                let ray = Ray::leaving(receiver.p, way / distance, end, receiver.primitive);
                self.rays.push(Ray { ends: Ends::OnSurfaces, ..ray });
            }
            let place = (!matte).then_some(self.weights.len() as u16);
            self.weights.extend(place.map(|_| weight));
            let (source, receiver) = ((first + j) as u8, (first + i) as u8);
            self.shares.push(Share { source, receiver, is_seen, weight: place, geometry, density });
        }
    }

    /// Hands on what is seen, and forgets.
    pub fn settle(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &[Shared],
        counters: &mut Counters,
    ) {
        let Self { rays, shares, weights, occluded } = self;
        occluded.clear();
        occluded.resize(rays.len(), false);
        counters.rays += rays.len() as u64;
        counters.shared += rays.len() as u64;
        scene.accel.occluded_all(rays, occluded);
        let asked = shares.iter_mut().filter(|share| !share.is_seen);
        asked.zip(occluded).for_each(|(share, occluded)| share.is_seen = !*occluded);
        for shares in shares.chunk_by(|a, b| a.source == b.source) {
            let seen = shares.iter().filter(|share| share.is_seen);
            let light = shared[usize::from(shares[0].source)].radiance;
            hand_on(paths, light, seen.map(|share| share.part(shared, weights)));
        }
        rays.clear();
        shares.clear();
        weights.clear();
    }
}
