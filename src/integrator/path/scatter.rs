//! Scattering at a vertex: light that it asks for, and where the path goes on.

use super::reuse::Shared;
use super::shadows::Shadows;
use super::stream::State;
use super::vertex::Arrival;
use super::{Path, survival};
use crate::bsdf::{Bsdf, Material, Visitor};
use crate::emitter::{DirectSample, EmitterPoint};
use crate::integrator::light::{self, Proposal, Sampled, Vertex};
use crate::integrator::links::{self, Link, Way};
use crate::integrator::{CameraPath, Counters, caustics, guide};
use crate::math::{DVec3, Ray};
use crate::sampler::Numbers;
use crate::scene::{Features, Scene, Side};
use crate::shape::SurfacePoint;

/// Scattering at a vertex, for a material still to be named.
pub struct Scatter<'a, const F: u32> {
    pub settings: &'a Path,
    pub scene: &'a Scene,
    pub index: usize,
    pub path: &'a mut CameraPath,
    pub state: &'a mut State,
    pub shared: &'a mut Shared,
    pub way: &'a mut Way,
    pub counters: &'a mut Counters,
    /// World, towards where the path came from.
    pub wo: DVec3,
    pub primitive: u32,
    pub point: &'a SurfacePoint,
    pub side: Side,
    pub u: Numbers,
    pub shadows: &'a mut Shadows,
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
        if F & Features::REUSE != 0 && settings.reuse > 1 {
            shared.arrive(&vertex, settings, state, λ);
            state.tail.arrive(shared.source.as_ref(), &vertex);
        }
        // What the camera's ray knows only of the first vertex.
        let first = Some(path.ray).filter(|_| state.depth == 0);
        let numbers = |which: u32, count: u32| match count {
            1 => u,
            count => sampler.emitter_sample(state.depth, which, count),
        };
        let samples = if state.mirrored { settings.first_emitter_samples } else { settings.emitter_samples };
        let mut gathers_about = DVec3::ZERO;
        if side.traits.smooth {
            if F & Features::ENVIRONMENT != 0 || scene.emitters.chosen_by_place() {
                gathers_about = vertex.gathers_about();
            }
            let counts = (f64::from(samples), 1.0);
            let focuses = state.depth > 0 && side.traits.focuses();
            let ratio = if focuses { state.light_ratio } else { 0.0 };
            let light_paths = |emitter: usize, light: &DirectSample, own: f64| match &scene.caustics {
                Some(caustics) if F & Features::CAUSTICS != 0 && ratio > 0.0 && light.n != DVec3::ZERO => {
                    let p = point.p + light.wi * light.distance;
                    let end = EmitterPoint { emitter, p, n: light.n };
                    let here = ratio_at(scene, &vertex, (wo, None), vertex.to_local(light.wi), 1.0);
                    ratio * here * caustics.last(scene, end, -light.wi) / own
                }
                _ => 0.0,
            };
            let casts = F & Features::CAUSTICS != 0 && focuses && scene.caustics.is_some();
            let shares =
                F & Features::REUSE != 0 && state.shares && (!casts || shared.receives_casters(scene));
            let throughput = if shares { state.throughput } else { state.own_throughput::<F>(shared) };
            let owner = (index, shares);
            for which in 0..samples {
                let u = numbers(which, samples);
                let u = (u.pair(0), u.one(4));
                let found = light::sample_emitter(scene, &vertex, gathers_about, u, counts, λ, light_paths);
                let Some((Proposal { ray, radiance }, sampled)) = found else { continue };
                let rivals = || {
                    let Sampled { emitter, light, density } = sampled;
                    let end = EmitterPoint { emitter, p: point.p + light.wi * light.distance, n: light.n };
                    let factor = || state.tail.factor(&vertex, vertex.to_local(light.wi), density);
                    state.tail.rivals(scene, factor, end, -light.wi)
                };
                let rivals = if F & Features::REUSE != 0 && shares && !casts { rivals() } else { None };
                match rivals {
                    Some(rivals) => shadows.contest(index, rivals, ray, throughput * radiance),
                    None => shadows.push(owner, ray, throughput * radiance),
                }
            }
        }
        let casts_to_all = F & Features::REUSE != 0 && state.shares && shared.receives_casters(scene);
        let throughput = if casts_to_all { state.throughput } else { state.own_throughput::<F>(shared) };
        let unaided = scene.caustics.is_none() || state.light_ratio == 0.0;
        let asks = F & Features::CAUSTICS != 0 && side.traits.smooth;
        let links = scene.links.as_ref().filter(|links| asks && (links.everywhere || unaided));
        let seen = scene.guide.as_ref().filter(|_| asks && unaided).map(|guide| guide.at(point.p));
        let most = settings.max_depth.saturating_sub(state.depth + 2) as usize;
        if let Some(links) = links.filter(|_| most > 0) {
            let light_paths = |link: &Link, pdf: f64, end: EmitterPoint| match &scene.caustics {
                Some(caustics) if state.light_ratio > 0.0 => {
                    let to_light = vertex.to_local(link.direction);
                    let here = ratio_at(scene, &vertex, (wo, first), to_light, pdf);
                    state.light_ratio * here / link.eta2 * caustics.last(scene, end, -link.last.direction)
                }
                _ => 0.0,
            };
            let effort = (settings.emitter_samples as f64, most);
            for which in 0..settings.emitter_samples {
                let u = numbers(which, settings.emitter_samples);
                for mirror in links.techniques(point.p, u.one(7)) {
                    let which = (mirror, u.pair(0), u.one(4));
                    let found =
                        links::sample_emitter(scene, &vertex, which, effort, λ, light_paths, counters);
                    if let Some(light) = found {
                        shadows.push((index, casts_to_all), light.ray, throughput * light.radiance);
                    }
                }
            }
        }
        if let Some(seen) = seen.filter(|_| most > 0) {
            let numbers = (sampler, state.depth, most as u32);
            let found = guide::sample_emitters(scene, &vertex, seen, numbers, λ, counters);
            let sum = if casts_to_all { &mut shared.radiance } else { &mut path.radiance };
            *sum += throughput * found;
        }
        // Where no direction has a density none is drawn.
        let lobe = if side.traits.smooth { u.one(5) } else { u.one(2) };
        let sample = bsdf.sample(vertex.wo, lobe, u.pair(1));
        path.covered |= !sample.is_some_and(|sample| sample.null);
        let sample = sample?;
        if F & Features::CAUSTICS != 0 && scene.caustics.is_some() && state.light_ratio > 0.0 {
            state.light_ratio *= match sample.delta {
                _ if side.traits.one_way => 0.0,
                true if side.traits.relief || state.depth == 0 => 0.0,
                true => 1.0 / (sample.eta * sample.eta),
                false => ratio_at(scene, &vertex, (wo, first), sample.wi, sample.pdf),
            };
        }
        if F & Features::CAUSTICS != 0 {
            // Whether or not light paths could make what is behind it: pixels that share must agree on what
            // they share.
            state.from_caster = state.depth > 0 && side.traits.focuses();
            if links.is_some() || seen.is_some() {
                *way = Way::begin((point.p, primitive), vertex.to_world(sample.wi), &sample, seen);
            } else if side.traits.smooth {
                *way = Way::NONE;
            } else {
                way.follow(vertex.wo, side, primitive, &sample);
            }
        }
        if F & Features::REUSE != 0 {
            shared.leave(state, sample.wi);
            state.tail.leave(&vertex, &sample);
        }
        state.throughput *= sample.weight;
        state.eta2 *= sample.eta * sample.eta;
        state.arrival =
            Arrival { pdf: sample.pdf, delta: sample.delta, n: gathers_about, emitter_samples: samples };
        state.direct_view &= sample.null;
        state.mirrored &= sample.delta;
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
            // The largest lane: a red path between red walls must not be punished for its other lanes. What a
            // lossless path has lost to rounding is no loss: in a thousand reflections it would end one path
            // in thousands. What is shared must not end for want of colour in the path's own receiver: others
            // see it too.
            let survival = survival(λ.peak(state.throughput) as f64 * state.eta2, state.depth);
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

/// The factor of r (see [`caustics`]) that a vertex brings with a direction to the light (local) that was
/// sampled with density `pdf`, seen from `wo` (world): as the first vertex on the camera's ray, if that is
/// given, or as a further one.
fn ratio_at<B: Bsdf>(
    scene: &Scene,
    vertex: &Vertex<B>,
    (wo, first): (DVec3, Option<Ray>),
    to_light: DVec3,
    pdf: f64,
) -> f64 {
    let point = vertex.point;
    let cos_light = point.ng.dot(vertex.to_world(to_light)).abs();
    let cos_camera = point.ng.dot(wo).abs();
    match first {
        Some(ray) => caustics::first(pdf, cos_light, scene.pixels_per_area(&ray, point.p) * cos_camera),
        None => {
            let to_camera = vertex.bsdf.evaluate(to_light, vertex.wo).pdf;
            caustics::further(to_camera, pdf, cos_camera, cos_light)
        }
    }
}
