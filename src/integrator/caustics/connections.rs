//! Connections of light paths with the camera, collected until their shadow rays are traced.

use super::light_path::Splat;
use crate::integrator::Counters;
use crate::integrator::wavefront::occluded;
use crate::math::Ray;
use crate::scene::Scene;

/// Connections of light paths with the camera.
#[derive(Default)]
pub struct Connections {
    /// Shadow rays of the last entries of `asked`, those not yet resolved.
    rays: Vec<Ray>,
    /// All connections, each with its path's index in the stream. They are large, so they are never moved.
    asked: Vec<(usize, Splat)>,
    occluded: Vec<bool>,
    /// Indices into `asked` of those that are unoccluded.
    arrived: Vec<usize>,
}

impl Connections {
    #[inline(always)]
    pub fn push(&mut self, index: usize, ray: Ray, splat: Splat) {
        self.rays.push(ray);
        self.asked.push((index, splat));
    }

    /// Traces the shadow rays of all connections pushed since the last call.
    pub fn resolve(&mut self, scene: &Scene, counters: &mut Counters) {
        occluded(scene, &self.rays, &mut self.occluded, counters);
        let first = self.asked.len() - self.rays.len();
        let free = self.occluded.iter().enumerate().filter(|(_, occluded)| !**occluded);
        self.arrived.extend(free.map(|(i, _)| first + i));
        self.rays.clear();
    }

    /// Passes all unoccluded connections to `splat`: path by path, those of a path in the order of
    /// [`Self::push`].
    pub fn hand_on(&mut self, mut splat: impl FnMut(usize, &Splat)) {
        self.arrived.sort_by_key(|i| self.asked[*i].0);
        for i in self.arrived.drain(..) {
            let (index, found) = &self.asked[i];
            splat(*index, found);
        }
        self.asked.clear();
    }
}
