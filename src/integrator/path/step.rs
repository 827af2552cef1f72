//! A vertex of a camera path: the emission that it meets, and the surface at which it scatters.

use super::Path;
use super::escapes::Escape;
use super::reuse::Contested;
use super::scatter::Scatter;
use super::shadows::Shadows;
use super::stream::{InFlight, Pending};
use crate::emitter::{Choice, EmitterPoint};
use crate::integrator::MAX_VERTICES;
use crate::integrator::arrival::Met;
use crate::integrator::mis::power_heuristic_of_ratios;
use crate::integrator::wavefront::Arrived;
use crate::integrator::{Counters, Event};
use crate::math::Ray;
use crate::sampler::Numbers;
use crate::scene::{Features, Scene};

impl Path {
    /// Processes the vertex at the end of a ray; returns the next ray, or `None` if the path ends.
    #[inline(always)]
    pub fn step<const F: u32>(
        &self,
        scene: &Scene,
        InFlight { index, path, state, gathers, shared, chain }: InFlight,
        Arrived { ray, hit, .. }: Arrived,
        u: &Numbers,
        Pending { shadows, escapes }: &mut Pending,
        counters: &mut Counters,
    ) -> Option<Ray> {
        let Some(hit) = hit else {
            if F & Features::ENVIRONMENT != 0 && !(self.lengths.hide_emitters && state.direct_view) {
                let view = scene.emitters.view(ray.direction)?;
                escapes.push(Escape {
                    path: index,
                    shares: state.shares,
                    throughput: state.throughput,
                    from: ray.origin,
                    arrival: state.arrival,
                    view,
                });
            }
            return None;
        };
        let (shape, point) = scene.surface::<F>(ray, &hit);
        if let Some(emitter) = shape.emitter {
            // As in Mitsuba: behind a `null` surface emitters are seen again, surroundings are not.
            if self.lengths.hide_emitters && state.depth == 0 {
                // Light paths do not see the camera through an emitter.
                state.light_ratio = 0.0;
                return Some(point.ray(ray.direction, f64::INFINITY, hit.primitive));
            }
            let met = Met { ray, t: hit.t, shape, point: &point, emitter: emitter as usize };
            let flight = InFlight { index, path, state, gathers, shared, chain };
            self.meet::<F>(scene, flight, met, shadows, counters);
        }
        if let Some(log) = &mut counters.log {
            let (throughput, radiance) = (state.throughput, path.radiance);
            log.push(Event { t: hit.t, primitive: Some(hit.primitive), p: point.p, throughput, radiance });
        }
        if state.depth + 1 >= self.lengths.max_depth {
            return None;
        }
        let side = shape.side_towards(point.ns.dot(-ray.direction));
        let onward = scene.materials[side.material as usize].visit(Scatter::<F> {
            settings: self,
            scene,
            flight: InFlight { index, path, state, gathers, shared, chain },
            wo: -ray.direction,
            primitive: hit.primitive,
            point: &point,
            side,
            u,
            shadows,
            counters,
        })?;
        if state.depth >= MAX_VERTICES {
            counters.cut += 1;
            return None;
        }
        Some(onward)
    }

    /// Takes the light of an emitter that a path has met.
    #[inline(always)]
    fn meet<const F: u32>(
        &self,
        scene: &Scene,
        InFlight { index, path, state, gathers, shared, chain }: InFlight,
        met: Met,
        shadows: &mut Shadows,
        counters: &mut Counters,
    ) {
        let λ = &mut path.λ;
        path.covered |= !self.lengths.hide_emitters;
        let Met { ray, point, emitter, .. } = met;
        let emitted = met.radiance(scene, λ);
        if emitted.is_zero() {
            return;
        }
        let end = EmitterPoint { emitter, p: point.p, n: point.ng };
        let by_emitter = if state.arrival.delta {
            if F & Features::CAUSTICS != 0 {
                chain.emitter_density_ratio(scene, end, f64::from(self.emitter_samples), λ, counters)
            } else {
                0.0
            }
        } else {
            let choice = Choice::at(gathers.at(ray.origin));
            met.density_of_samples(scene, &choice, state.arrival.emitter_samples) / state.arrival.pdf
        };
        let by_light_path = match &scene.techniques.caustics {
            Some(caustics) if F & Features::CAUSTICS != 0 && state.from_caster => {
                state.light_ratio * caustics.ratio_at_emitter(scene, end, -ray.direction)
            }
            _ => 0.0,
        };
        let weight = power_heuristic_of_ratios(by_emitter, by_light_path) as f32;
        let light = state.throughput * emitted * weight;
        if F & Features::REUSE == 0 || !state.shares {
            path.radiance += light;
        } else if F & Features::CAUSTICS != 0 && scene.techniques.caustics.is_some() && state.from_caster {
            match shared.receives_casters(scene) {
                true => shared.radiance += light,
                false => path.radiance += shared.own * light,
            }
        } else {
            let factor = || 1.0 / (1.0 + by_emitter);
            match state.tail.rivals(scene, factor, end, -ray.direction) {
                Some(rivals) => shadows.contested.push(Contested { path: index, rivals, light }),
                None => shared.radiance += light,
            }
        }
    }
}
