//! A light path that finds sources: its state and its scattering.

use super::light_sources::{LightSource, LightSources, Owner};
use super::rivals::Rivals;
use super::shared::Source;
use crate::bsdf::Bsdf;
use crate::emitter::EmitterPoint;
use crate::integrator::caustics::{Landing, Leg, ratio_at_vertex};
use crate::integrator::emitter_sampling::density_of_finding;
use crate::integrator::roulette::roulette;
use crate::integrator::vertex::Vertex;
use crate::math::{DVec3, Ray};
use crate::sampler::{Sampler, blocks};
use crate::scene::{Features, Scene};
use crate::spectrum::{Spectrum, Wavelengths};

/// Edges before roulette begins.
const SURE_EDGES: u32 = 2;

/// The state of a light path between two vertices.
pub struct LightPath {
    owner: Owner,
    sampler: Sampler,
    /// The overflow of its number above 32 bits.
    beyond: u32,
    λ: Wavelengths,
    end: EmitterPoint,
    emitted: Spectrum,
    /// Product of the factors of the estimate at all vertices beyond the emitter so far.
    throughput: Spectrum,
    /// cos / density at the emitter, over the number of light paths, apart from the throughput: a lane might
    /// not hold it.
    scale: f64,
    /// Product of the factors of c so far; see [`super::rivals`].
    ratio: f64,
    /// Density of the ray's direction if the last vertex is matte, else zero.
    from_matte: f64,
}

impl LightPath {
    /// The path and its first ray; `None` if no light leaves there. The sampler is that of the group.
    pub fn begin(
        sources: &LightSources,
        scene: &Scene,
        owner: Owner,
        sampler: Sampler,
        λ: Wavelengths,
    ) -> Option<(Self, Ray)> {
        let (sampler, beyond) = sampler.one_of(owner.light_path, sources.paths);
        let u = sampler.block(blocks::shared_light_path(beyond, 0));
        let start = sources.emission.sample(&scene.emitters, &scene.shapes, &u, &λ)?;
        let scale = start.cos / (start.density * f64::from(sources.paths));
        let path = Self {
            owner,
            sampler,
            beyond,
            λ,
            end: start.end,
            emitted: start.radiance,
            throughput: λ.ones(),
            scale,
            ratio: 1.0 / scale,
            from_matte: 0.0,
        };
        Some((path, start.ray))
    }

    /// Sampler and block of the numbers for the vertex after so many edges.
    pub fn numbers(&self, edges: u32) -> (&Sampler, u32) {
        (&self.sampler, blocks::shared_light_path(self.beyond, edges))
    }

    /// Notes a source at the hit, the vertex after so many edges, if that is matte, and samples the next ray;
    /// `None` ends the path.
    pub fn step(
        &mut self,
        sources: &LightSources,
        scene: &Scene,
        Landing { ray, hit, edges, u }: Landing,
        found: &mut Vec<LightSource>,
    ) -> Option<Ray> {
        let (shape, point) = scene.surface::<{ Features::ALL }>(ray, &hit);
        let to_light = -ray.direction;
        let side = shape.side_towards(point.ns.dot(to_light));
        let left_to_others = edges == 1 && side.traits.is_caster() && scene.techniques.caustics.is_some();
        if side.traits.irreversible || !side.traits.has_density || left_to_others {
            return None;
        }
        let frame = side.frame::<{ Features::ALL }>(&point);
        let bsdf = scene.materials[side.material as usize].at(&point, &self.λ);
        let primitive = hit.primitive;
        let vertex = Vertex::new(&point, primitive, &frame, &bsdf, side, to_light);
        let cos_light = point.ng.dot(to_light).abs();
        let by_emitter = |to_camera| match edges {
            1 => density_of_finding(scene, self.end, &vertex, to_camera, to_light, hit.t),
            _ => 0.0,
        };
        let albedo = bsdf.albedo().filter(|_| vertex.wo.z > 0.0);
        if let Some(albedo) = albedo {
            let scattered = bsdf.evaluate(DVec3::Z, vertex.wo);
            let radiance = self.throughput * self.emitted * scattered.value;
            if !radiance.is_zero() {
                let (p, n, ng) = (point.p, vertex.to_world(DVec3::Z), point.ng);
                let by_light = self.ratio * cos_light / (scattered.pdf + by_emitter(DVec3::Z));
                found.push(LightSource {
                    owner: self.owner,
                    source: Source {
                        p,
                        error: scene.point_error(primitive, p),
                        n,
                        ng,
                        primitive,
                        albedo,
                        lobes: None,
                    },
                    edges,
                    radiance,
                    scale: self.scale / cos_light,
                    rivals: Rivals::new(
                        by_light,
                        self.from_matte * cos_light / (hit.t * hit.t),
                        sources.paths,
                    ),
                });
            }
        }
        let (lobe, direction) = u.scattering();
        let sample = bsdf.sample(vertex.wo, lobe, direction).filter(|sample| !sample.delta)?;
        let to_camera = vertex.to_world(sample.wi);
        let cos_camera = point.ng.dot(to_camera).abs();
        let back = bsdf.evaluate(sample.wi, vertex.wo);
        self.throughput *= back.value * (cos_camera / (sample.pdf * cos_light)) as f32;
        self.ratio *= ratio_at_vertex(
            Leg { pdf: sample.pdf, cos: cos_camera },
            Leg { pdf: back.pdf + by_emitter(sample.wi), cos: cos_light },
        );
        self.from_matte = if albedo.is_some() { sample.pdf } else { 0.0 };
        if self.throughput.is_zero() {
            return None;
        }
        if edges >= SURE_EDGES {
            let carried = self.λ.mean(self.throughput) as f64;
            self.throughput *= roulette(carried, edges, false, u.roulette())?;
        }
        Some(point.ray(to_camera, f64::INFINITY, primitive))
    }
}
