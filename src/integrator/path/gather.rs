//! Emitter samples at a vertex: in a straight line, and by mirrors and through glass.

use super::Path;
use super::reuse::Shared;
use super::shadows::{Destination, Shadows};
use super::stream::State;
use crate::bsdf::{Bsdf, Sample};
use crate::emitter::{Choice, DirectSample, EmitterPoint, Gathers};
use crate::integrator::Counters;
use crate::integrator::caustics::{Leg, ratio_at_camera, ratio_at_vertex};
use crate::integrator::emitter_sampling::{EmitterSample, SampleCounts, sample_emitter};
use crate::integrator::guide::{self, Directions, GuidedSample};
use crate::integrator::links::{self, Link, LinkSample, Links};
use crate::integrator::vertex::Vertex;
use crate::math::{DVec3, Ray};
use crate::sampler::{Numbers, PAIRS, Sampler};
use crate::scene::{Features, Scene};
use crate::spectrum::{Spectrum, Wavelengths};

/// A vertex that takes emitter samples, and the state of the path there.
pub struct Gather<'s, 'a, B, const F: u32> {
    pub settings: &'a Path,
    pub scene: &'s Scene,
    pub index: usize,
    pub vertex: &'a Vertex<'a, B>,
    pub state: &'a State,
    pub λ: &'a Wavelengths,
    pub sampler: &'a Sampler,
    pub u: &'a Numbers,
    /// Direction (world) to where the path came from.
    pub wo: DVec3,
    /// The camera's ray, at the first vertex.
    pub first: Option<Ray>,
}

/// What finds ways to emitters by mirrors and through glass, if anything does.
#[derive(Clone, Copy)]
pub struct SpecularSampling<'s> {
    links: Option<&'s Links>,
    /// The directions in which light paths have seen such ways begin.
    pub seen: Option<&'s Directions>,
}

impl SpecularSampling<'_> {
    pub fn any(&self) -> bool {
        self.links.is_some() || self.seen.is_some()
    }
}

impl<'s, B: Bsdf, const F: u32> Gather<'s, '_, B, F> {
    /// Takes `count` emitter samples; `gathers` is [`Vertex::gathers`], or everywhere
    /// where no choice depends on it.
    #[inline(always)]
    pub fn sample_emitters(&self, count: u32, gathers: &Gathers, shared: &Shared, shadows: &mut Shadows) {
        let Self { scene, vertex, state, λ, .. } = *self;
        let caster = state.depth > 0 && vertex.side.traits.is_caster();
        let ratio = if caster { state.light_ratio } else { 0.0 };
        let light_paths = |emitter: usize, light: &DirectSample, own: f64| match &scene.techniques.caustics {
            Some(caustics) if F & Features::CAUSTICS != 0 && ratio > 0.0 && light.n != DVec3::ZERO => {
                let here = self.ratio(vertex.to_local(light.wi), 1.0);
                ratio * here * caustics.ratio_at_emitter(scene, self.end(emitter, light), -light.wi) / own
            }
            _ => 0.0,
        };
        let casts = F & Features::CAUSTICS != 0 && caster && scene.techniques.caustics.is_some();
        let (throughput, shares) = state.delivers::<F>(scene, shared, casts);
        let receiver = gathers.at(vertex.point.p);
        let choice = match count {
            1 => Choice::at(receiver),
            _ => Choice::of_several(&scene.emitters, receiver),
        };
        for which in 0..count {
            let u = match count {
                1 => self.u.emitter_sample(),
                _ => shadows.numbers(scene, self.sampler, state.depth, which, count),
            };
            let counts = SampleCounts { emitter: f64::from(count), bsdf: 1.0 };
            let found = sample_emitter(scene, vertex, &choice, u, counts, λ, light_paths);
            let Some((mut proposal, sampled)) = found else { continue };
            if F & Features::ENVIRONMENT == 0 {
                // It is none already; told so, the compiler leaves out what asks for it.
                proposal.environment = None;
            }
            let rivals = || {
                let EmitterSample { emitter, light, density } = sampled;
                let factor = || state.tail.factor(vertex, vertex.to_local(light.wi), density);
                state.tail.rivals(scene, factor, self.end(emitter, &light), -light.wi)
            };
            let rivals = if F & Features::REUSE != 0 && shares && !casts { rivals() } else { None };
            match rivals {
                Some(rivals) => shadows.contest(self.index, rivals, throughput, proposal),
                None => shadows.push(Destination { path: self.index, shares }, throughput, proposal),
            }
        }
    }

    /// What is to look here for ways by mirrors and through glass: everywhere, or where light paths cannot
    /// help.
    #[inline(always)]
    pub fn specular_sampling(&self) -> SpecularSampling<'s> {
        let Self { scene, vertex, state, .. } = *self;
        let unaided = scene.techniques.caustics.is_none() || state.light_ratio == 0.0;
        let asks = F & Features::CAUSTICS != 0 && vertex.side.traits.has_density;
        SpecularSampling {
            links: scene.techniques.links.as_ref().filter(|links| asks && (links.everywhere || unaided)),
            seen: scene
                .techniques
                .guide
                .as_ref()
                .filter(|_| asks && unaided)
                .map(|guide| guide.at(vertex.point.p)),
        }
    }

    /// Takes emitter samples that lead by specular surfaces of these kinds. What needs no test for visibility goes
    /// to `radiance`, which is the pixel's, or to what is shared.
    #[inline(always)]
    pub fn sample_by_chains(
        &self,
        specular: SpecularSampling,
        shared: &mut Shared,
        radiance: &mut Spectrum,
        shadows: &mut Shadows,
        counters: &mut Counters,
    ) {
        let Self { settings, scene, vertex, state, λ, .. } = *self;
        let most = settings.lengths.max_depth.saturating_sub(state.depth + 2) as usize;
        if !specular.any() || most == 0 {
            return;
        }
        let (throughput, shares) = state.delivers::<F>(scene, shared, true);
        if let Some(links) = specular.links {
            let light_paths = |link: &Link, pdf: f64, end: EmitterPoint| match &scene.techniques.caustics {
                Some(caustics) if state.light_ratio > 0.0 && !vertex.side.traits.irreversible => {
                    let here = self.ratio(vertex.to_local(link.direction), pdf);
                    state.light_ratio * here / link.eta2
                        * caustics.ratio_at_emitter(scene, end, -link.last.direction)
                }
                _ => 0.0,
            };
            let count = settings.emitter_samples;
            let to = Destination { path: self.index, shares };
            let one = (count == 1).then_some(*self.u);
            let several = (count > 1).then(|| self.sampler.each_emitter_sample(state.depth, count, PAIRS));
            for u in one.into_iter().chain(several.into_iter().flatten()) {
                for connector in links.connectors(vertex.point.p, u.link()) {
                    let numbers = u.emitter_sample();
                    let sample = LinkSample { connector, numbers, count: f64::from(count), most };
                    let found = |proposal| shadows.push(to, throughput, proposal);
                    links::sample_by_links(scene, vertex, sample, λ, light_paths, counters, found);
                }
            }
        }
        if let Some(directions) = specular.seen {
            let (sampler, depth, most) = (self.sampler, state.depth, most as u32);
            let sample = GuidedSample { directions, sampler, depth, most };
            let found = guide::sample_guided(scene, vertex, sample, λ, counters);
            let sum = if shares { &mut shared.radiance } else { radiance };
            *sum += throughput * found;
        }
    }

    /// The state's ratio of light paths behind this vertex, where the path goes on with this sample.
    #[inline(always)]
    pub fn ratio_behind(&self, sample: &Sample) -> f64 {
        let Self { scene, state, .. } = *self;
        let traits = self.vertex.side.traits;
        if scene.techniques.caustics.is_none() || state.light_ratio == 0.0 {
            return state.light_ratio;
        }
        state.light_ratio
            * match sample.delta {
                _ if traits.irreversible => 0.0,
                true if traits.relief || state.depth == 0 => 0.0,
                true => 1.0 / (sample.eta * sample.eta),
                false => self.ratio(sample.wi, sample.pdf),
            }
    }

    /// The factor of r, see [`caustics`](crate::integrator::caustics), that the vertex brings with a direction to
    /// the light (local) that was sampled with density `pdf`.
    fn ratio(&self, to_light: DVec3, pdf: f64) -> f64 {
        let Self { scene, vertex, wo, .. } = *self;
        let point = vertex.point;
        let towards = Leg { pdf, cos: point.ng.dot(vertex.to_world(to_light)).abs() };
        let cos_camera = point.ng.dot(wo).abs();
        match self.first {
            Some(ray) => ratio_at_camera(towards, scene.pixels_per_area(&ray, point.p) * cos_camera),
            None => {
                let back = vertex.bsdf.evaluate(to_light, vertex.wo).pdf;
                ratio_at_vertex(Leg { pdf: back, cos: cos_camera }, towards)
            }
        }
    }

    /// The point of an emitter that was sampled from here.
    fn end(&self, emitter: usize, light: &DirectSample) -> EmitterPoint {
        EmitterPoint { emitter, p: self.vertex.point.p + light.wi * light.distance, n: light.n }
    }
}
