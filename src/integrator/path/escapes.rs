//! Rays that have left the scene, collected until what they see there has come from memory.

use super::reuse::Shared;
use crate::emitter::{Gathers, View};
use crate::integrator::CameraPath;
use crate::integrator::arrival::{Arrival, environment_in_view};
use crate::math::DVec3;
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// A ray that has left the scene.
pub struct Escape {
    /// Its path's place in the stream.
    pub path: usize,
    /// Whether other pixels share what it finds.
    pub shares: bool,
    pub throughput: Spectrum,
    /// Where it began (world).
    pub from: DVec3,
    /// How its direction was sampled there.
    pub arrival: Arrival,
    pub view: View,
}

/// The rays of one step of a stream that have left the scene.
#[derive(Default)]
pub struct Escapes(Vec<Escape>);

impl Escapes {
    pub fn push(&mut self, escape: Escape) {
        self.0.push(escape);
    }

    /// Adds the light that they see.
    pub fn resolve(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        gathers: &[Gathers],
        shared: &mut [Shared],
    ) {
        for Escape { path, shares, throughput, from, arrival, view } in self.0.drain(..) {
            let light = throughput
                * environment_in_view(scene, &view, gathers[path].at(from), &arrival, &paths[path].λ);
            let found = if shares { &mut shared[path].radiance } else { &mut paths[path].radiance };
            *found += light;
        }
    }
}
