//! Scattering at a vertex: emitters are sampled, then the next direction.

use super::Path;
use super::chain::ChainSince;
use super::gather::Gather;
use super::shadows::Shadows;
use super::stream::InFlight;
use crate::bsdf::{Bsdf, Material, Visitor};
use crate::integrator::Counters;
use crate::integrator::arrival::Arrival;
use crate::integrator::vertex::Vertex;
use crate::math::{DVec3, Ray};
use crate::sampler::Numbers;
use crate::scene::{Features, Scene, Side};
use crate::shape::SurfacePoint;

/// Scattering at a vertex, for any type of material.
pub struct Scatter<'a, const F: u32> {
    pub settings: &'a Path,
    pub scene: &'a Scene,
    pub flight: InFlight<'a>,
    /// Direction (world) to where the path came from.
    pub wo: DVec3,
    pub primitive: u32,
    pub point: &'a SurfacePoint,
    pub side: &'a Side,
    pub u: &'a Numbers,
    pub shadows: &'a mut Shadows,
    pub counters: &'a mut Counters,
}

impl<const F: u32> Visitor for Scatter<'_, F> {
    type Output = Option<Ray>;

    /// Takes emitter samples and samples the next ray.
    #[inline]
    fn visit<M: Material>(self, material: &M) -> Option<Ray> {
        let Self { settings, scene, flight, wo, primitive, point, side, u, shadows, counters } = self;
        let InFlight { index, path, state, gathers, shared, chain } = flight;
        let frame = side.frame::<F>(point);
        let bsdf = material.at(point, &path.λ);
        let vertex = Vertex::new(point, primitive, &frame, &bsdf, side, wo);
        if F & Features::REUSE != 0 && settings.reuse > 1 {
            shared.arrive(scene, &vertex, settings, state, &path.λ);
            state.tail.arrive(shared.source.as_ref(), &vertex);
        }
        let here = Gather::<_, F> {
            settings,
            scene,
            index,
            vertex: &vertex,
            state,
            λ: &path.λ,
            sampler: &path.sampler,
            u,
            wo,
            first: Some(path.ray).filter(|_| state.depth == 0),
        };
        let emitter_samples =
            if state.specular_so_far { settings.first_emitter_samples } else { settings.emitter_samples };
        if side.traits.has_density {
            if F & Features::ENVIRONMENT != 0 || scene.emitters.chosen_by_place() {
                *gathers = vertex.gathers(scene, vertex.wo);
            }
            here.sample_emitters(emitter_samples, gathers, shared, shadows);
        }
        let specular = here.specular_sampling();
        here.sample_by_chains(specular, shared, &mut path.radiance, shadows, counters);
        let (lobe, direction) = u.scattering_if(side.traits.has_density);
        let sample = bsdf.sample(vertex.wo, lobe, direction);
        path.covered |= !sample.is_some_and(|sample| sample.null);
        let sample = sample?;
        if F & Features::CAUSTICS != 0 {
            state.light_ratio = here.ratio_behind(&sample);
            // Whether or not light paths could make what is behind it: pixels that share must agree on what
            // they share.
            state.from_caster = state.depth > 0 && side.traits.is_caster();
            if specular.any() {
                *chain =
                    ChainSince::begin(vertex.origin(), vertex.to_world(sample.wi), &sample, specular.seen);
            } else if side.traits.has_density {
                *chain = ChainSince::Nothing;
            } else {
                chain.follow(vertex.wo, side, primitive, &sample);
            }
        }
        if F & Features::REUSE != 0 {
            shared.leave(state, sample.wi);
            state.tail.leave(&vertex, &sample);
        }
        state.throughput *= sample.weight;
        state.eta2 *= sample.eta * sample.eta;
        state.arrival = Arrival { pdf: sample.pdf, delta: sample.delta, emitter_samples };
        state.direct_view &= sample.null;
        state.specular_so_far &= sample.delta;
        state.vertices_since_rough += u32::from(!state.specular_so_far);
        state.depth += 1;
        if state.throughput.is_zero() {
            return None;
        }
        let onward = point.ray(vertex.to_world(sample.wi), f64::INFINITY, primitive);
        drop(bsdf);
        if F & Features::DISPERSION != 0 && sample.dispersed {
            path.λ.collapse();
        }
        if settings.roulette.may_have_begun(state.depth) {
            // By the largest lane: a red path between red walls must not end early because of its other
            // lanes. What is shared must not end because the path's own receiver is dark: others see it too.
            let carried = path.λ.peak(state.throughput) as f64 * state.eta2;
            let (edges, vertices) = (state.depth, state.vertices_since_rough);
            state.throughput *=
                settings.roulette.play(carried, edges, vertices, sample.delta, u.roulette())?;
        }
        Some(onward)
    }
}
