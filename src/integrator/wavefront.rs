//! Paths that take each step together (Laine, Karras and Aila 2013, "Megakernels Considered Harmful").
//!
//! Rays that lie side by side can share vector registers, and the steps of neighbours overlap in the
//! processor.

use super::Counters;
use crate::math::Ray;
use crate::scene::Scene;
use crate::shape::Hit;

/// How many paths are traced together: enough to fill vector registers most of the time, few enough for the
/// nearest cache.
pub const STREAM: usize = 64;

/// The paths that still go on, with their rays side by side.
#[derive(Default)]
pub struct Wavefront {
    paths: Vec<usize>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
}

/// Where a path's ray has arrived.
pub struct Arrived<'a> {
    /// The path's place among those that still go on.
    pub place: usize,
    /// The path's number, as given to [`Wavefront::begin`].
    pub path: usize,
    pub ray: &'a Ray,
    /// `None` where the ray leaves the scene.
    pub hit: Option<Hit>,
}

impl Wavefront {
    /// Begins with these paths, by number, and their first rays.
    pub fn begin(&mut self, paths: impl Iterator<Item = (usize, Ray)>) {
        self.paths.clear();
        self.rays.clear();
        for (path, ray) in paths {
            self.paths.push(path);
            self.rays.push(ray);
        }
        self.hits.resize(self.paths.len(), None);
    }

    /// How many paths still go on.
    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Traces all rays; returns the numbers of their paths.
    #[inline]
    pub fn trace(&mut self, scene: &Scene, counters: &mut Counters) -> &[usize] {
        counters.rays += self.rays.len() as u64;
        scene.accel.closest_all(&self.rays, &mut self.hits);
        scene.prefetch_surfaces(&self.hits[..self.rays.len()]);
        &self.paths
    }

    /// Calls `step` for each path in order; it returns the path's next ray, or `None` if the path ends.
    #[inline(always)]
    pub fn advance(&mut self, mut step: impl FnMut(Arrived) -> Option<Ray>) {
        let Self { paths, rays, hits } = self;
        let mut kept = 0;
        let hits = &hits[..paths.len()];
        for (place, &hit) in hits.iter().enumerate() {
            let path = paths[place];
            let arrived = Arrived { place, path, ray: &rays[place], hit };
            if let Some(onward) = step(arrived) {
                (paths[kept], rays[kept]) = (path, onward);
                kept += 1;
            }
        }
        paths.truncate(kept);
        rays.truncate(kept);
    }
}

/// Whether each ray is occluded; `occluded` gets as many entries as there are rays.
pub fn occluded(scene: &Scene, rays: &[Ray], occluded: &mut Vec<bool>, counters: &mut Counters) {
    occluded.resize(rays.len(), false);
    counters.rays += rays.len() as u64;
    scene.accel.occluded_all(rays, occluded);
}
