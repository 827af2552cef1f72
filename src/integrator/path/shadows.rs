//! Contributions of emitter samples, collected until their shadow rays are traced.

use super::FEW_EMITTERS;
use super::reuse::{Contested, Rivals, Shared};
use crate::emitter::MapPlace;
use crate::integrator::emitter_sampling::Proposal;
use crate::integrator::wavefront::{STREAM, occluded};
use crate::integrator::{CameraPath, Counters};
use crate::math::Ray;
use crate::sampler::{EmitterNumbers, ManyNumbers, Sampler};
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Where a contribution goes.
#[derive(Clone, Copy)]
pub struct Destination {
    /// The path's place in the stream.
    pub path: usize,
    /// Whether other pixels share it.
    pub shares: bool,
}

/// Contributions with their shadow rays.
#[derive(Default)]
pub struct Shadows {
    pub rays: Vec<Ray>,
    light: Vec<(Destination, Spectrum)>,
    /// The place in the environment map that a contribution comes from, by its place here: what is
    /// there is looked up if it arrives.
    mapped: Vec<(usize, MapPlace)>,
    /// What else finds some of what is shared, by its place.
    rivals: Vec<(usize, Rivals)>,
    occluded: Vec<bool>,
    /// Numbers of up to eight emitter samples at a vertex.
    numbers: ManyNumbers<8>,
    /// What is shared of that and has arrived.
    pub contested: Vec<Contested>,
}

impl Shadows {
    /// With more rays than this, they are traced without waiting for the rest of the stream.
    pub const MANY: usize = 4 * STREAM;

    /// The numbers of one of `count` emitter samples at a vertex, which must be requested in order.
    #[inline(never)]
    pub fn numbers(
        &mut self,
        scene: &Scene,
        sampler: &Sampler,
        depth: u32,
        which: u32,
        count: u32,
    ) -> EmitterNumbers {
        if which.is_multiple_of(8) {
            // Place, and more digits for the choice of the emitter.
            let pairs = if scene.emitters.list.len() > FEW_EMITTERS { 3 } else { 1 };
            self.numbers = sampler.emitter_samples(depth, which, count, pairs);
        }
        self.numbers.of(which as usize % 8).emitter_sample()
    }

    #[inline(always)]
    pub fn push(&mut self, to: Destination, throughput: Spectrum, proposal: Proposal) {
        if let Some(place) = proposal.environment {
            self.mapped.push((self.light.len(), place));
        }
        self.rays.push(proposal.ray);
        self.light.push((to, throughput * proposal.radiance));
    }

    /// Light that is shared and that light paths find as well.
    pub fn contest(&mut self, path: usize, rivals: Rivals, throughput: Spectrum, proposal: Proposal) {
        self.rivals.push((self.light.len(), rivals));
        self.push(Destination { path, shares: true }, throughput, proposal);
    }

    /// Traces the shadow rays and adds what is unoccluded, in the order in which it was pushed.
    pub fn resolve(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &mut [Shared],
        counters: &mut Counters,
    ) {
        occluded(scene, &self.rays, &mut self.occluded, counters);
        for (index, place) in self.mapped.drain(..).filter(|(index, _)| !self.occluded[*index]) {
            let (to, light) = &mut self.light[index];
            *light *= scene.emitters.mapped(&place, &paths[to.path].λ);
        }
        // Contested light goes where it is parted.
        for (place, rivals) in self.rivals.drain(..) {
            let (Destination { path, .. }, light) = self.light[place];
            if !std::mem::replace(&mut self.occluded[place], true) {
                self.contested.push(Contested { path, rivals, light });
            }
        }
        for ((Destination { path, shares }, light), occluded) in self.light.drain(..).zip(&self.occluded) {
            match occluded {
                true => {}
                false if shares => shared[path].radiance += light,
                false => paths[path].radiance += light,
            }
        }
        self.rays.clear();
    }
}
