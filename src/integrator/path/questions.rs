//! Which receivers see a source.

use super::exchange::Part;
use super::shared::{Shared, Source};
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

/// What a receiver may have of a source; there are thousands at a time.
struct Share {
    source: u8,
    receiver: u8,
    is_seen: bool,
    has_weight: bool,
    geometry: f64,
    density: f64,
}

impl Questions {
    /// Asks about those that are not known to be in sight; all are matte or not.
    pub fn ask(
        &mut self,
        group: &[Shared],
        (first, j, source): (usize, usize, &Source),
        (in_sight, matte): (u64, bool),
        parts: impl Iterator<Item = (usize, Part)>,
    ) {
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
            if !matte {
                self.weights.push(weight);
            }
            // A stream is no longer.
            let (source, receiver) = ((first + j) as u8, (first + i) as u8);
            self.shares.push(Share { source, receiver, is_seen, has_weight: !matte, geometry, density });
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
        let mut weights = weights.drain(..);
        for shares in shares.chunk_by(|a, b| a.source == b.source) {
            let light = shared[usize::from(shares[0].source)].radiance;
            let seen = |share: &&Share| share.is_seen;
            let all = 1.0 / shares.iter().filter(seen).map(|share| share.density).sum::<f64>();
            for share in shares {
                let receiver = usize::from(share.receiver);
                let own = shared[receiver].receiver.as_ref().map(|receiver| receiver.weight);
                let Some(weight) = (if share.has_weight { weights.next() } else { own }) else { continue };
                if share.is_seen {
                    paths[receiver].radiance += weight * light * (share.geometry * all) as f32;
                }
            }
        }
        rays.clear();
        shares.clear();
    }
}
