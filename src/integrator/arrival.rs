//! How a ray was sampled that may meet an emitter, and what weighs the light that it finds there: emitter samples
//! could have found it as well.

use super::mis::power_heuristic;
use crate::emitter::{Choice, GatherPoint, Gathers, View};
use crate::math::Ray;
use crate::scene::{Scene, Shape};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// How a path's last direction was sampled: what the MIS weight of an emitter at its end depends on.
#[derive(Clone, Copy)]
pub struct Arrival {
    /// The density of the direction, in sr⁻¹.
    pub pdf: f64,
    /// The direction could not have been found by sampling an emitter.
    pub delta: bool,
    /// Number of emitter samples taken at the previous vertex.
    pub emitter_samples: u32,
}

impl Arrival {
    /// A camera ray, which no emitter sample competes with.
    pub const FROM_CAMERA: Self = Self { pdf: 1.0, delta: true, emitter_samples: 1 };
}

/// An emitting surface that a ray has met.
#[derive(Clone, Copy)]
pub struct Met<'a> {
    /// From the point of which the densities of emitter samples are asked.
    pub ray: &'a Ray,
    /// How far along the ray.
    pub t: f64,
    pub shape: &'a Shape,
    pub point: &'a SurfacePoint,
    /// Index of the emitter.
    pub emitter: usize,
}

impl Met<'_> {
    /// The radiance that comes back along the ray.
    #[inline(always)]
    pub fn radiance(&self, scene: &Scene, λ: &Wavelengths) -> Spectrum {
        scene.emitters.list[self.emitter].emitter.surface_radiance(self.point, -self.ray.direction, λ)
    }

    /// The radiance, weighted against the emitter samples that were taken where the ray begins.
    #[inline]
    pub fn weighted(&self, scene: &Scene, choice: &Choice, arrival: &Arrival, λ: &Wavelengths) -> Spectrum {
        let emitted = self.radiance(scene, λ);
        if arrival.delta || emitted.is_zero() {
            return emitted;
        }
        let rival = self.density_of_samples(scene, choice, arrival.emitter_samples);
        emitted * power_heuristic(arrival.pdf, rival) as f32
    }

    /// The density in sr⁻¹ with which `count` emitter samples at the ray's origin, together, find the point.
    #[inline(always)]
    pub fn density_of_samples(&self, scene: &Scene, choice: &Choice, count: u32) -> f64 {
        let emitter = &scene.emitters.list[self.emitter].emitter;
        let pdf = emitter.surface_pdf(&self.shape.geometry, self.ray, self.t, self.point);
        choice.density_of_samples(&scene.emitters, self.emitter, pdf, count)
    }
}

/// Light from the environment along a ray that met nothing.
#[inline]
pub fn environment_along(
    scene: &Scene,
    ray: &Ray,
    gathers: &Gathers,
    arrival: &Arrival,
    λ: &Wavelengths,
) -> Spectrum {
    let seen = |view| environment_in_view(scene, &view, gathers.at(ray.origin), arrival, λ);
    scene.emitters.view(ray.direction).map_or(Spectrum::ZERO, seen)
}

/// The same, where the environment has been looked up already.
#[inline]
pub fn environment_in_view(
    scene: &Scene,
    view: &View,
    from: GatherPoint,
    arrival: &Arrival,
    λ: &Wavelengths,
) -> Spectrum {
    let Some(index) = scene.emitters.environment else { return Spectrum::ZERO };
    let emitter = &scene.emitters.list[index].emitter;
    let Some(radiance) = emitter.distant_radiance(view, λ) else { return Spectrum::ZERO };
    if arrival.delta {
        return radiance;
    }
    let pdf = emitter.distant_pdf(view, from.gathers.n);
    let choice = Choice::at(from);
    let rival = choice.density_of_samples(&scene.emitters, index, pdf, arrival.emitter_samples);
    radiance * power_heuristic(arrival.pdf, rival) as f32
}
