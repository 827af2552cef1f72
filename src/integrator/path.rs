//! Unidirectional path tracing with direct light by multiple importance sampling.

use super::light::{self, Vertex, power_heuristic};
use super::{AnyIntegrator, Counters, Event};
use crate::bsdf::{AnyBsdf, Bsdf};
use crate::math::{DVec2, DVec3, Ray};
use crate::sampler::{FIRST_VERTEX, FURTHER_EMITTER_SAMPLES, Sampler};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::{Features, Scene, Shape, Side};
use crate::spectrum::{Spectrum, Wavelengths};

pub const NAME: &str = "path";
pub const ABOUT: &str = "Path tracing: all light that a camera path can find, unbiased.";
pub const EXAMPLES: &[&str] = &[
    r#"<integrator type="path"/>"#,
    r#"<integrator type="path"><integer name="max_depth" value="8"/><integer name="rr_depth" value="5"/>
        <integer name="emitter_samples" value="4"/></integrator>"#,
];

/// No path goes on beyond this many vertices. Roulette ends paths long before, except where nothing is ever
/// absorbed; such paths are counted and reported.
pub const MAX_VERTICES: u32 = 1 << 20;

/// The settings, with Mitsuba's meaning of each.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Edges of the longest path: 1 sees emitters, 2 direct light, and so on.
    pub max_depth: u32,
    /// Edges before Russian roulette begins.
    pub rr_depth: u32,
    /// Emitters are not seen directly.
    pub hide_emitters: bool,
    /// Emitter samples at every vertex; Mitsuba takes one.
    pub emitter_samples: u32,
}

impl Default for Path {
    fn default() -> Self {
        Self { max_depth: u32::MAX, rr_depth: 5, hide_emitters: false, emitter_samples: 1 }
    }
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    let about = "edges of the longest path; −1 means no limit";
    let max_depth = params.integer("max_depth", -1, -1..=i64::from(u32::MAX), about)?;
    let about = "edges before Russian roulette begins";
    let rr_depth = params.integer("rr_depth", 5, 1..=i64::from(u32::MAX), about)? as u32;
    let hide_emitters = params.boolean("hide_emitters", false, "emitters are not seen directly")?;
    let about = "emitter samples at every vertex (an extension)";
    let emitter_samples = params.integer("emitter_samples", 1, 1..=1024, about)? as u32;
    let max_depth = u32::try_from(max_depth).unwrap_or(u32::MAX);
    Ok(AnyIntegrator::Path(Path { max_depth, rr_depth, hide_emitters, emitter_samples }))
}

/// How the path came to where it is: what its next emitter is to be weighed with.
#[derive(Clone, Copy)]
pub struct Arrival {
    /// The density of the direction, in sr⁻¹.
    pub pdf: f64,
    /// The direction could not have been found by sampling an emitter.
    pub delta: bool,
}

impl Path {
    /// Estimates the radiance along a camera ray. `λ` may come back collapsed to its first lane.
    pub fn radiance<const F: u32>(
        &self,
        scene: &Scene,
        mut ray: Ray,
        λ: &mut Wavelengths,
        sampler: &Sampler,
        counters: &mut Counters,
    ) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        if self.max_depth == 0 {
            return radiance;
        }
        let mut throughput = Spectrum::ONE;
        // The square of the relative index the path is in: radiance inside glass is larger by it, and roulette
        // must not take that for importance.
        let mut eta2 = 1.0;
        let mut arrival = Arrival { pdf: 1.0, delta: true };
        // Whether the ray still goes straight from the camera.
        let mut direct_view = true;
        let mut depth = 0;
        loop {
            counters.rays += 1;
            let Some(hit) = scene.accel.closest(&ray) else {
                if F & Features::ENVIRONMENT != 0 && !(self.hide_emitters && direct_view) {
                    radiance += throughput * environment(scene, &ray, arrival, self.emitter_samples, λ);
                }
                break;
            };
            let (shape, point) = if F & Features::TEXTURES != 0 {
                scene.surface::<true>(&ray, &hit)
            } else {
                scene.surface::<false>(&ray, &hit)
            };
            if let Some(index) = shape.emitter {
                if self.hide_emitters && depth == 0 {
                    ray = Ray::leaving(point.p, ray.direction, ray.end - hit.t, hit.primitive);
                    continue;
                }
                let entry = &scene.emitters.list[index as usize];
                let emitted = entry.emitter.surface_radiance(&point, -ray.direction, λ);
                if !emitted.is_zero() {
                    let weight = if arrival.delta {
                        1.0
                    } else {
                        let pdf = entry.emitter.surface_pdf(&shape.geometry, &ray, hit.t, &point);
                        let rival =
                            scene.emitters.probability(index as usize) * pdf * self.emitter_samples as f64;
                        power_heuristic(arrival.pdf, rival)
                    };
                    radiance += throughput * emitted * weight as f32;
                }
            }
            if let Some(log) = &mut counters.log {
                log.push(Event { hit, p: point.p, throughput, radiance, nm: λ.nm[0] });
            }
            if depth + 1 >= self.max_depth {
                break;
            }
            let towards = point.ns.dot(-ray.direction);
            let side = side_towards(shape, towards);
            let frame = point.frame(F & Features::ANISOTROPY != 0 && side.traits.anisotropic);
            let bsdf: AnyBsdf = scene.materials[side.material as usize].at(&point, λ);
            let mut vertex = Vertex {
                point: &point,
                primitive: hit.primitive,
                frame: &frame,
                bsdf: &bsdf,
                wo: DVec3::ZERO,
                side,
            };
            vertex.wo = vertex.to_local(-ray.direction);

            let u = sampler.block(FIRST_VERTEX + depth);
            if side.traits.smooth {
                let count = self.emitter_samples as f64;
                let direct = light::sample_emitter(
                    scene,
                    &vertex,
                    u[4],
                    DVec2::new(u[0], u[1]),
                    (count, 1.0),
                    λ,
                    counters,
                );
                radiance += throughput * direct;
                for further in 1..self.emitter_samples {
                    let u = sampler.block(FURTHER_EMITTER_SAMPLES + depth * 1024 + further);
                    let u_light = DVec2::new(u[0], u[1]);
                    let direct =
                        light::sample_emitter(scene, &vertex, u[4], u_light, (count, 1.0), λ, counters);
                    radiance += throughput * direct;
                }
            }
            let Some(sample) = bsdf.sample(vertex.wo, u[5], DVec2::new(u[2], u[3])) else { break };
            let direction = vertex.to_world(sample.wi);
            throughput *= sample.weight;
            if F & Features::DISPERSION != 0 && sample.dispersed {
                λ.collapsed = true;
            }
            eta2 *= sample.eta * sample.eta;
            arrival = Arrival { pdf: sample.pdf, delta: sample.delta };
            direct_view &= sample.null;
            ray = Ray::leaving(point.p, direction, f64::INFINITY, hit.primitive);
            depth += 1;
            if throughput.is_zero() {
                break;
            }
            if depth >= self.rr_depth {
                let survival = λ.mean(throughput) as f64 * eta2;
                if survival < 1.0 {
                    if u[6] >= survival {
                        break;
                    }
                    throughput *= (1.0 / survival) as f32;
                }
            }
            if depth >= MAX_VERTICES {
                counters.cut += 1;
                break;
            }
        }
        radiance
    }
}

/// What the side of a surface wears on which a direction with this cosine lies.
#[inline]
pub fn side_towards(shape: &Shape, cos: f64) -> Side {
    shape.sides[usize::from(cos < 0.0)]
}

/// Light from the environment along a ray that met nothing.
#[inline]
pub fn environment(
    scene: &Scene,
    ray: &Ray,
    arrival: Arrival,
    emitter_samples: u32,
    λ: &Wavelengths,
) -> Spectrum {
    let Some(index) = scene.emitters.environment else { return Spectrum::ZERO };
    let emitter = &scene.emitters.list[index].emitter;
    let Some((radiance, pdf)) = emitter.distant_radiance(ray.direction, λ) else { return Spectrum::ZERO };
    if arrival.delta {
        return radiance;
    }
    let rival = scene.emitters.probability(index) * pdf * emitter_samples as f64;
    radiance * power_heuristic(arrival.pdf, rival) as f32
}
