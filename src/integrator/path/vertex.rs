//! What happens where a path has arrived: light that it meets, light that it asks for, and where it goes on.

use super::reuse::{Receiver, Shared, Source};
use super::shadows::Shadows;
use super::stream::State;
use super::{MAX_VERTICES, Path};
use crate::bsdf::{Bsdf, Material, Visitor};
use crate::emitter::DirectSample;
use crate::integrator::caustics;
use crate::integrator::light::{self, Vertex, power_heuristic, power_heuristic_of_three};
use crate::integrator::through_glass::{self, Link, Way};
use crate::integrator::{CameraPath, Counters, Event};
use crate::math::{DVec3, Ray};
use crate::sampler::{FURTHER_EMITTER_SAMPLES, Numbers};
use crate::scene::{Features, Scene, Shape, Side};
use crate::shape::{Hit, SurfacePoint};
use crate::spectrum::{Spectrum, Wavelengths};

/// How the path came to where it is: what its next emitter is to be weighed with.
#[derive(Clone, Copy)]
pub struct Arrival {
    /// The density of the direction, in sr⁻¹.
    pub pdf: f64,
    /// The direction could not have been found by sampling an emitter.
    pub delta: bool,
    /// What the vertex before gathers light about; see [`Vertex::gathers_about`]. Zero where nothing surrounds the scene.
    pub n: DVec3,
}

impl Path {
    /// What happens where a ray has arrived; the ray with which the path goes on.
    #[inline(always)]
    pub fn step<const F: u32>(
        &self,
        scene: &Scene,
        (index, path, state, shared, way): (usize, &mut CameraPath, &mut State, &mut Shared, &mut Way),
        (ray, hit): (&Ray, Option<Hit>),
        u: Numbers,
        shadows: &mut Shadows,
        counters: &mut Counters,
    ) -> Option<Ray> {
        let λ = &mut path.λ;
        let Some(hit) = hit else {
            if F & Features::ENVIRONMENT != 0 && !(self.hide_emitters && state.direct_view) {
                let light = environment(scene, ray, state.arrival, self.emitter_samples, λ);
                let found = if state.shares { &mut shared.radiance } else { &mut path.radiance };
                *found += state.throughput * light;
                path.covered |= scene.emitters.environment.is_some();
            }
            return None;
        };
        let (shape, point) = if F & Features::TEXTURES != 0 {
            scene.surface::<true>(ray, &hit)
        } else {
            scene.surface::<false>(ray, &hit)
        };
        if let Some(emitter) = shape.emitter {
            if self.hide_emitters && state.depth == 0 {
                // Light paths do not see the camera through an emitter.
                state.light_ratio = 0.0;
                return Some(Ray::leaving(point.p, ray.direction, ray.end - hit.t, hit.primitive));
            }
            path.covered |= !self.hide_emitters;
            let entry = &scene.emitters.list[emitter as usize];
            let emitted = entry.emitter.surface_radiance(&point, -ray.direction, λ);
            if !emitted.is_zero() {
                let count = self.emitter_samples as f64;
                let by_emitter = if state.arrival.delta {
                    if F & Features::CAUSTICS != 0 {
                        way.rival(scene, (emitter as usize, &point), count, λ, counters)
                    } else {
                        0.0
                    }
                } else {
                    let pdf = entry.emitter.surface_pdf(&shape.geometry, ray, hit.t, &point);
                    let chosen = scene.emitters.probability(emitter as usize);
                    chosen * pdf * count / state.arrival.pdf
                };
                let by_light_path = match &scene.caustics {
                    Some(caustics) if F & Features::CAUSTICS != 0 && state.from_caster => {
                        let end = (emitter as usize, point.p, point.ng);
                        state.light_ratio * caustics.last(scene, end, -ray.direction)
                    }
                    _ => 0.0,
                };
                let weight = power_heuristic_of_three(by_emitter, by_light_path) as f32;
                let light = state.throughput * emitted * weight;
                if !state.shares {
                    path.radiance += light;
                } else if F & Features::CAUSTICS != 0 && scene.caustics.is_some() && state.from_caster {
                    path.radiance += shared.albedo() * light;
                } else {
                    shared.radiance += light;
                }
            }
        }
        if let Some(log) = &mut counters.log {
            let (throughput, radiance) = (state.throughput, path.radiance);
            log.push(Event { hit, p: point.p, throughput, radiance, nm: λ.nm[0] });
        }
        if state.depth + 1 >= self.max_depth {
            // The surroundings would have been seen at last, and they cover everything.
            path.covered |= !self.hide_emitters && scene.emitters.environment.is_some();
            return None;
        }
        let side = side_towards(shape, point.ns.dot(-ray.direction));
        let onward = scene.materials[side.material as usize].visit(Scatter::<F> {
            settings: self,
            scene,
            index,
            path,
            state,
            shared,
            way,
            counters,
            wo: -ray.direction,
            primitive: hit.primitive,
            point: &point,
            side,
            u,
            shadows,
        })?;
        if state.depth >= MAX_VERTICES {
            counters.cut += 1;
            return None;
        }
        Some(onward)
    }
}

/// Scattering at a vertex, for a material still to be named.
struct Scatter<'a, const F: u32> {
    settings: &'a Path,
    scene: &'a Scene,
    index: usize,
    path: &'a mut CameraPath,
    state: &'a mut State,
    shared: &'a mut Shared,
    way: &'a mut Way,
    counters: &'a mut Counters,
    /// World, towards where the path came from.
    wo: DVec3,
    primitive: u32,
    point: &'a SurfacePoint,
    side: Side,
    u: Numbers,
    shadows: &'a mut Shadows,
}

impl<const F: u32> Visitor for Scatter<'_, F> {
    type Output = Option<Ray>;

    /// Asks for direct light and finds the ray with which the path goes on.
    #[inline]
    fn visit<M: Material>(self, material: &M) -> Option<Ray> {
        let Self {
            settings,
            scene,
            index,
            path,
            state,
            shared,
            way,
            counters,
            wo,
            primitive,
            point,
            side,
            u,
            shadows,
        } = self;
        let (λ, sampler) = (&mut path.λ, &path.sampler);
        let frame = point.frame(F & Features::ANISOTROPY != 0 && side.traits.anisotropic);
        let bsdf = material.at(point, λ);
        let mut vertex = Vertex { point, primitive, frame: &frame, bsdf: &bsdf, wo: DVec3::ZERO, side };
        vertex.wo = vertex.to_local(wo);
        if F & Features::REUSE != 0 && settings.reuse > 1 && vertex.wo.z > 0.0 {
            match (state.depth, bsdf.albedo()) {
                (0, Some(albedo)) if settings.rr_depth > 1 && !albedo.is_zero() => {
                    let n = vertex.to_world(DVec3::Z);
                    shared.receiver = Some(Receiver { p: point.p, n, primitive, albedo });
                }
                (1, Some(_)) if shared.receiver.is_some() => {
                    let n = vertex.to_world(DVec3::Z);
                    shared.source = Some(Source { p: point.p, n, ng: point.ng });
                    (state.throughput, state.shares) = (Spectrum::ONE, true);
                }
                _ => {}
            }
        }
        let numbers = |which: u32| match which {
            0 => u,
            further => sampler.block(FURTHER_EMITTER_SAMPLES + state.depth * 1024 + further),
        };
        let mut gathers_about = DVec3::ZERO;
        if side.traits.smooth {
            if F & Features::ENVIRONMENT != 0 {
                gathers_about = vertex.gathers_about();
            }
            let counts = (settings.emitter_samples as f64, 1.0);
            let focuses = state.depth > 0 && side.traits.focuses();
            let ratio = if focuses { state.light_ratio } else { 0.0 };
            let light_paths = |emitter: usize, light: &DirectSample| match &scene.caustics {
                Some(caustics) if F & Features::CAUSTICS != 0 && ratio > 0.0 && light.n != DVec3::ZERO => {
                    let end = (emitter, point.p + light.wi * light.distance, light.n);
                    let to_camera = bsdf.evaluate(vertex.to_local(light.wi), vertex.wo).pdf;
                    let (cos_light, cos_camera) = (point.ng.dot(light.wi).abs(), point.ng.dot(wo).abs());
                    let ratio = ratio * caustics::further(to_camera, 1.0, cos_camera, cos_light);
                    ratio * caustics.last(scene, end, -light.wi)
                }
                _ => 0.0,
            };
            // What light paths make as well is weighed for this pixel alone.
            let alone = F & Features::CAUSTICS != 0 && focuses && scene.caustics.is_some();
            let shares = state.shares && !alone;
            let throughput =
                if state.shares && !shares { state.throughput * shared.albedo() } else { state.throughput };
            let owner = (index, shares);
            for which in 0..settings.emitter_samples {
                let u = numbers(which);
                let u = (u.one(4), u.pair(0));
                let found = light::sample_emitter(scene, &vertex, gathers_about, u, counts, λ, light_paths);
                if let Some(light) = found {
                    shadows.push(owner, light.ray, throughput * light.radiance);
                }
            }
        }
        let through_glass = F & Features::CAUSTICS != 0
            && side.traits.smooth
            && scene.through_glass.as_ref().is_some_and(|glass| {
                glass.everywhere || scene.caustics.is_none() || state.light_ratio == 0.0
            });
        let most = settings.max_depth.saturating_sub(state.depth + 2) as usize;
        if through_glass && most > 0 {
            let light_paths = |link: &Link, pdf: f64, end: (usize, DVec3, DVec3)| match &scene.caustics {
                Some(caustics) if state.light_ratio > 0.0 => {
                    let (cos_light, cos_camera) =
                        (point.ng.dot(link.direction).abs(), point.ng.dot(wo).abs());
                    let here = if state.depth == 0 {
                        let seen = scene.pixels_per_area(&path.ray, point.p) * cos_camera;
                        caustics::first(false, pdf, cos_light, seen)
                    } else {
                        let to_camera = bsdf.evaluate(vertex.to_local(link.direction), vertex.wo).pdf;
                        caustics::further(to_camera, pdf, cos_camera, cos_light)
                    };
                    state.light_ratio * here / link.eta2 * caustics.last(scene, end, -link.last.direction)
                }
                _ => 0.0,
            };
            // Like all that casters throw, this is for the pixel alone.
            let throughput = if state.shares { state.throughput * shared.albedo() } else { state.throughput };
            for which in 0..settings.emitter_samples {
                let u = numbers(which);
                let (u, effort) = ((u.one(4), u.pair(0)), (settings.emitter_samples as f64, most));
                let found =
                    through_glass::sample_emitter(scene, &vertex, u, effort, λ, light_paths, counters);
                if let Some(light) = found {
                    shadows.push((index, false), light.ray, throughput * light.radiance);
                }
            }
        }
        let sample = bsdf.sample(vertex.wo, u.one(5), u.pair(1));
        path.covered |= !sample.is_some_and(|sample| sample.null);
        let sample = sample?;
        if F & Features::CAUSTICS != 0 && state.light_ratio > 0.0 {
            let to_light = vertex.to_world(sample.wi);
            let (cos_light, cos_camera) = (point.ng.dot(to_light).abs(), point.ng.dot(wo).abs());
            state.light_ratio *= if sample.delta && side.traits.one_way {
                0.0
            } else if state.depth == 0 {
                let seen = scene.pixels_per_area(&path.ray, point.p) * cos_camera;
                caustics::first(sample.delta, sample.pdf, cos_light, seen)
            } else if sample.delta {
                1.0 / (sample.eta * sample.eta)
            } else {
                let to_camera = bsdf.evaluate(sample.wi, vertex.wo).pdf;
                caustics::further(to_camera, sample.pdf, cos_camera, cos_light)
            };
        }
        if F & Features::CAUSTICS != 0 {
            // Whether or not light paths could make what is behind it: pixels that share must agree on what they share.
            state.from_caster = state.depth > 0 && side.traits.focuses();
            if through_glass {
                *way = Way::begin((point.p, primitive), vertex.to_world(sample.wi), &sample);
            } else if side.traits.smooth {
                *way = Way::NONE;
            } else {
                way.follow(vertex.wo, side, &sample);
            }
        }
        state.throughput *= sample.weight;
        state.eta2 *= sample.eta * sample.eta;
        state.arrival = Arrival { pdf: sample.pdf, delta: sample.delta, n: gathers_about };
        state.direct_view &= sample.null;
        state.depth += 1;
        if state.throughput.is_zero() {
            return None;
        }
        let onward = Ray::leaving(point.p, vertex.to_world(sample.wi), f64::INFINITY, primitive);
        drop(bsdf);
        if F & Features::DISPERSION != 0 && sample.dispersed {
            λ.collapse();
        }
        if state.depth >= settings.rr_depth {
            // The largest lane: a red path between red walls must not be punished for its other lanes. What a lossless
            // path has lost to rounding is no loss: in a thousand reflections it would end one path in thousands.
            let throughput = if state.shares { state.throughput * shared.albedo() } else { state.throughput };
            let survival = λ.peak(throughput) as f64 * state.eta2;
            let rounding = 4.0 * state.depth as f64 * f32::EPSILON as f64;
            if survival < 1.0 - rounding {
                if u.one(6) >= survival {
                    return None;
                }
                state.throughput *= (1.0 / survival) as f32;
            }
        }
        Some(onward)
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
    let Some((radiance, pdf)) = emitter.distant_radiance(ray.direction, arrival.n, λ) else {
        return Spectrum::ZERO;
    };
    if arrival.delta {
        return radiance;
    }
    let rival = scene.emitters.probability(index) * pdf * emitter_samples as f64;
    radiance * power_heuristic(arrival.pdf, rival) as f32
}
