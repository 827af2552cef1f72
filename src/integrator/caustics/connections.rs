//! Light that waits to be tested for whether the camera sees it.

use super::light_path::Splat;
use crate::integrator::Counters;
use crate::integrator::wavefront::occluded;
use crate::math::Ray;
use crate::scene::Scene;

/// Connections of light paths with the camera.
#[derive(Default)]
pub struct Connections {
    /// Of the last ones that were asked for.
    rays: Vec<Ray>,
    /// All, each with the path's place in its stream. They are large, and stay where they are.
    asked: Vec<(usize, Splat)>,
    occluded: Vec<bool>,
    /// Which of them arrive.
    arrived: Vec<usize>,
}

impl Connections {
    #[inline(always)]
    pub fn push(&mut self, index: usize, ray: Ray, splat: Splat) {
        self.rays.push(ray);
        self.asked.push((index, splat));
    }

    /// Finds out what arrives of what was asked for since the last time.
    pub fn resolve(&mut self, scene: &Scene, counters: &mut Counters) {
        occluded(scene, &self.rays, &mut self.occluded, counters);
        let first = self.asked.len() - self.rays.len();
        let free = self.occluded.iter().enumerate().filter(|(_, occluded)| !**occluded);
        self.arrived.extend(free.map(|(i, _)| first + i));
        self.rays.clear();
    }

    /// Hands on all that has arrived, path by path, each one's in the order in which it was asked for.
    pub fn hand_on(&mut self, mut splat: impl FnMut(usize, &Splat)) {
        self.arrived.sort_by_key(|i| self.asked[*i].0);
        for i in self.arrived.drain(..) {
            let (index, found) = &self.asked[i];
            splat(*index, found);
        }
        self.asked.clear();
    }
}
