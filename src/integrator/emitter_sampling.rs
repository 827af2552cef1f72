//! Direct light by sampling the emitters.

use super::mis::power_heuristic_of_ratios;
use super::vertex::Vertex;
use crate::bsdf::Bsdf;
use crate::emitter::{Choice, DirectSample, EmitterPoint, MapPlace, Radiance};
use crate::math::ray::Ends;
use crate::math::{Chosen, DVec3, Ray};
use crate::sampler::EmitterNumbers;
use crate::scene::Scene;
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// A contribution, and the shadow ray that decides whether it arrives.
#[derive(Clone, Copy, Debug)]
pub struct Proposal {
    /// Shadow ray to just before the emitter, from the vertex or, along a link, from its last surface.
    pub ray: Ray,
    /// Contribution to the radiance that leaves the vertex towards `wo`, with its MIS weight.
    pub radiance: Spectrum,
    /// Where in the environment map the light comes from, if it does: its radiance, which is looked up only if the
    /// light arrives, is still to be multiplied.
    pub environment: Option<MapPlace>,
}

impl Proposal {
    /// The whole contribution.
    #[inline]
    pub fn radiance(&self, scene: &Scene, λ: &Wavelengths) -> Spectrum {
        self.environment
            .as_ref()
            .map_or(self.radiance, |place| self.radiance * scene.emitters.mapped(place, λ))
    }
}

/// An emitter sample, and how likely it was.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSample {
    pub emitter: usize,
    pub light: DirectSample,
    /// Density of its direction, summed over all samples of both techniques, in sr⁻¹.
    pub density: f64,
}

/// How many samples each technique takes at a vertex.
#[derive(Clone, Copy, Debug)]
pub struct SampleCounts {
    pub emitter: f64,
    pub bsdf: f64,
}

impl SampleCounts {
    /// One of each.
    pub const ONE: Self = Self { emitter: 1.0, bsdf: 1.0 };
}

/// One emitter sample of so many, weighted against those of the BSDF: an estimate of the direct light that
/// this technique has to contribute, up to visibility.
///
/// With n light samples of density p and m BSDF samples of density q, the multi-sample power heuristic gives
/// a light sample the weight (np)²/((np)² + (mq)²), and its estimate is divided by n. `light_paths` gives,
/// for an emitter, a sample and its density np, the ratio to np of the density with which light paths make
/// the whole path, as one of directions; see [`super::caustics`]. `choice` is that at the vertex.
#[inline]
pub fn sample_emitter<B: Bsdf>(
    scene: &Scene,
    vertex: &Vertex<B>,
    choice: &Choice,
    numbers: EmitterNumbers,
    samples: SampleCounts,
    λ: &Wavelengths,
    light_paths: impl Fn(usize, &DirectSample, f64) -> f64,
) -> Option<(Proposal, EmitterSample)> {
    let Chosen { index, probability, rest: u } = choice.sample(&scene.emitters, numbers)?;
    let entry = &scene.emitters.list[index];
    let shape = entry.shape.map(|i| &scene.shapes[i as usize].geometry);
    let light = entry.emitter.sample(shape, choice.at.p, choice.at.gathers.n, u, λ)?;
    let scattered = vertex.bsdf.evaluate(vertex.wo, vertex.to_local(light.wi));
    let (radiance, environment) = match light.radiance {
        Radiance::Known(radiance) => (scattered.value * radiance, None),
        Radiance::Mapped(place) => (scattered.value, Some(place)),
    };
    if radiance.is_zero() {
        return None;
    }
    let pdf = light.pdf * probability;
    let weight = if light.delta {
        1.0
    } else {
        let own = samples.emitter * pdf;
        power_heuristic_of_ratios(samples.bsdf * scattered.pdf / own, light_paths(index, &light, own))
    };
    let ray = vertex.point.ray(light.wi, light.distance, vertex.primitive);
    let on_surfaces = entry.shape.is_some() && vertex.primitive != Ray::FREE;
    let proposal = Proposal {
        ray: if on_surfaces { Ray { ends: Ends::OnSurfaces, ..ray } } else { ray },
        radiance: radiance * (weight / (pdf * samples.emitter)) as f32,
        environment,
    };
    let density = samples.emitter * pdf + samples.bsdf * scattered.pdf;
    Some((proposal, EmitterSample { emitter: index, light, density }))
}

/// The density in sr⁻¹ with which all emitter samples of a camera path's vertex together find a point of an
/// emitter, in direction w (world) and at this distance, if the path has come from `to_camera` (local).
pub fn density_of_finding<B: Bsdf>(
    scene: &Scene,
    end: EmitterPoint,
    vertex: &Vertex<B>,
    to_camera: DVec3,
    w: DVec3,
    distance: f64,
) -> f64 {
    let entry = &scene.emitters.list[end.emitter];
    let (Some(shape), Some(path)) = (entry.shape, scene.integrator.path()) else { return 0.0 };
    let there = SurfacePoint::plain(end.p, end.n, end.n, 0.0);
    let (p, geometry) = (vertex.point.p, &scene.shapes[shape as usize].geometry);
    let pdf = entry.emitter.surface_pdf(geometry, &Ray::free(p, w), distance, &there);
    let gathers = vertex.gathers(scene, to_camera);
    Choice::at(gathers.at(p)).density_of_samples(&scene.emitters, end.emitter, pdf, path.emitter_samples)
}
