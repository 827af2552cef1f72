//! Light that waits to be tested for whether the camera sees it.

use super::light_path::Splat;
use crate::integrator::Counters;
use crate::math::Ray;
use crate::scene::Scene;

/// Connections of light paths with the camera, each with the path's place in its stream.
#[derive(Default)]
pub struct Connections {
    rays: Vec<Ray>,
    waiting: Vec<(usize, Splat)>,
    occluded: Vec<bool>,
    /// What arrives, in the order in which it was asked for.
    arrived: Vec<(usize, Splat)>,
    order: Vec<usize>,
}

impl Connections {
    pub fn push(&mut self, index: usize, ray: Ray, splat: Splat) {
        self.rays.push(ray);
        self.waiting.push((index, splat));
    }

    /// Finds out what arrives.
    pub fn resolve(&mut self, scene: &Scene, counters: &mut Counters) {
        counters.rays += self.rays.len() as u64;
        self.occluded.resize(self.rays.len(), false);
        scene.accel.occluded_all(&self.rays, &mut self.occluded);
        let waiting = self.waiting.drain(..).zip(&self.occluded);
        self.arrived.extend(waiting.filter(|(_, occluded)| !**occluded).map(|(splat, _)| splat));
        self.rays.clear();
    }

    /// Hands on all that has arrived, path by path, each one's in the order in which it was asked for.
    pub fn hand_on(&mut self, mut splat: impl FnMut(usize, &Splat)) {
        let Self { arrived, order, .. } = self;
        order.clear();
        order.extend(0..arrived.len());
        order.sort_by_key(|i| arrived[*i].0);
        for (index, found) in order.iter().map(|i| &arrived[*i]) {
            splat(*index, found);
        }
        arrived.clear();
    }
}
