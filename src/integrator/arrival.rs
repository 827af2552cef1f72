//! How a ray was sampled that may meet an emitter, and the weight of the light that it finds there, for
//! emitter samples could have found it as well.

use super::mis::power_heuristic;
use crate::emitter::{Choice, GatherPoint, Gathers, View};
use crate::math::Ray;
use crate::scene::Scene;
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
    pub const FROM_CAMERA: Self = Self { pdf: 1.0, delta: true, emitter_samples: 1 };

    /// The density in sr⁻¹ of all emitter samples at the previous vertex together, if that of one that has
    /// chosen this emitter is `pdf`.
    #[inline]
    pub fn density_of_samples(&self, scene: &Scene, from: GatherPoint, emitter: usize, pdf: f64) -> f64 {
        Choice::at(from).density_of_samples(&scene.emitters, emitter, pdf, self.emitter_samples)
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
    let rival = arrival.density_of_samples(scene, from, index, pdf);
    radiance * power_heuristic(arrival.pdf, rival) as f32
}
