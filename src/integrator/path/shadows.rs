//! Light that waits to be tested for visibility.

use super::shared::Shared;
use super::stream::STREAM;
use crate::integrator::{CameraPath, Counters};
use crate::math::Ray;
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Light that waits to be tested for visibility, the path it belongs to, and whether it is shared.
#[derive(Default)]
pub struct Shadows {
    pub rays: Vec<Ray>,
    light: Vec<(usize, bool, Spectrum)>,
    occluded: Vec<bool>,
}

impl Shadows {
    /// More than this need not wait.
    pub const MANY: usize = 4 * STREAM;

    pub fn push(&mut self, (path, shares): (usize, bool), ray: Ray, light: Spectrum) {
        self.rays.push(ray);
        self.light.push((path, shares, light));
    }

    /// Adds what arrives, in the order in which it was pushed.
    pub fn resolve(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &mut [Shared],
        counters: &mut Counters,
    ) {
        counters.rays += self.rays.len() as u64;
        self.occluded.resize(self.rays.len(), false);
        scene.accel.occluded_all(&self.rays, &mut self.occluded);
        for ((path, shares, light), occluded) in self.light.drain(..).zip(&self.occluded) {
            match occluded {
                true => {}
                false if shares => shared[path].radiance += light,
                false => paths[path].radiance += light,
            }
        }
        self.rays.clear();
    }
}
