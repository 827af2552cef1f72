//! Direct light only.

use super::arrival::{Arrival, Met, environment_along};
use super::emitter_sampling::{SampleCounts, sample_emitter};
use super::meter::Start;
use super::vertex::Vertex;
use super::{AnyIntegrator, CameraPath, Counters};
use crate::bsdf::{Bsdf, Sample};
use crate::emitter::Choice;
use crate::math::Ray;
use crate::sampler::PAIRS;
use crate::sampler::blocks::MOST_EMITTER_SAMPLES;
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::{Features, Scene};
use crate::spectrum::{Spectrum, Wavelengths};

pub const NAME: &str = "direct";
pub const ABOUT: &str =
    "Emitters and what they light directly, with chosen numbers of emitter and BSDF samples.";
pub const EXAMPLES: &[&str] = &[
    r#"<integrator type="direct"/>"#,
    r#"<integrator type="direct"><integer name="emitter_samples" value="4"/><integer name="bsdf_samples" value="2"/></integrator>"#,
];

/// Emitters, and what they light directly.
#[derive(Clone, Copy, Debug)]
pub struct Direct {
    emitter_samples: u32,
    bsdf_samples: u32,
    hide_emitters: bool,
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    const MOST: u32 = MOST_EMITTER_SAMPLES;
    let both = params.count("shading_samples", 1, 1..=MOST, "emitter and BSDF samples alike")?;
    let emitter_samples = params.count("emitter_samples", both, 0..=MOST, "samples of the emitters")?;
    let bsdf_samples = params.count("bsdf_samples", both, 0..=MOST, "samples of the BSDF")?;
    let hide_emitters = params.boolean("hide_emitters", false, "emitters are not seen directly")?;
    if emitter_samples + bsdf_samples == 0 {
        return Err(params.error(
            "bsdf_samples",
            "no samples at all",
            "expected at least one of either kind",
        ));
    }
    Ok(AnyIntegrator::Direct(Direct { emitter_samples, bsdf_samples, hide_emitters }))
}

impl Direct {
    /// Estimates the radiance along a camera ray.
    pub fn radiance<const F: u32>(
        &self,
        scene: &Scene,
        path: &mut CameraPath,
        counters: &mut Counters,
    ) -> Spectrum {
        let start = Start::of(scene, self.hide_emitters, path).unwrap_or(Start::FROM_CAMERA);
        let Start { arrival, gathers: before, found } = start;
        let CameraPath { ray, λ, sampler, covered, .. } = path;
        let mut radiance = Spectrum::ZERO;
        if let Some(light) = found {
            counters.rays += 1;
            if !scene.accel.occluded(&light.ray) {
                radiance += light.radiance(scene, λ);
            }
        }
        let mut ray = *ray;
        let (hit, shape, point) = loop {
            counters.rays += 1;
            let Some(hit) = scene.accel.closest(&ray) else {
                let hidden = F & Features::ENVIRONMENT == 0 || self.hide_emitters;
                return if hidden {
                    radiance
                } else {
                    radiance + environment_along(scene, &ray, &before, &arrival, λ)
                };
            };
            let (shape, point) = scene.surface::<F>(&ray, &hit);
            if !(self.hide_emitters && shape.emitter.is_some()) {
                break (hit, shape, point);
            }
            ray = point.ray(ray.direction, f64::INFINITY, hit.primitive);
        };
        *covered = true;
        if let Some(index) = shape.emitter {
            let met = Met { ray: &ray, t: hit.t, shape, point: &point, emitter: index as usize };
            radiance += met.weighted(scene, &Choice::at(before.at(ray.origin)), &arrival, λ);
        }
        let side = shape.side_towards(point.ns.dot(-ray.direction));
        let frame = side.frame::<F>(&point);
        let bsdf = scene.materials[side.material as usize].at(&point, λ);
        let vertex = Vertex::new(&point, hit.primitive, &frame, &bsdf, side, -ray.direction);
        let samples = SampleCounts { emitter: self.emitter_samples.into(), bsdf: self.bsdf_samples.into() };
        let gathers = vertex.gathers(scene, vertex.wo);
        let at = gathers.at(point.p);
        let choice =
            if side.traits.has_density { Choice::of_several(&scene.emitters, at) } else { Choice::at(at) };
        if side.traits.has_density {
            for u in sampler.each_emitter_sample(0, self.emitter_samples, PAIRS) {
                let numbers = u.emitter_sample();
                let found = sample_emitter(scene, &vertex, &choice, numbers, samples, λ, |_, _, _| 0.0);
                let Some((light, _)) = found else { continue };
                counters.rays += 1;
                if !scene.accel.occluded(&light.ray) {
                    radiance += light.radiance(scene, λ);
                }
            }
        }
        // No further vertex takes emitter samples.
        for u in sampler.each_emitter_sample(1, self.bsdf_samples, PAIRS) {
            let (lobe, direction) = u.scattering();
            let Some(sample) = bsdf.sample(vertex.wo, lobe, direction) else { continue };
            let onward = point.ray(vertex.to_world(sample.wi), f64::INFINITY, hit.primitive);
            let arrived = self.arriving::<F>(scene, &onward, &choice, &sample, λ, counters);
            radiance += sample.weight * arrived * (1.0 / samples.bsdf) as f32;
        }
        radiance
    }

    /// Emitted radiance along a sampled direction, weighted against the emitter samples of the vertex
    /// that it leaves.
    fn arriving<const F: u32>(
        &self,
        scene: &Scene,
        ray: &Ray,
        choice: &Choice,
        sample: &Sample,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> Spectrum {
        counters.rays += 1;
        let arrival = Arrival {
            pdf: self.bsdf_samples as f64 * sample.pdf,
            delta: sample.delta,
            emitter_samples: self.emitter_samples,
        };
        let Some(hit) = scene.accel.closest(ray) else {
            let seen = F & Features::ENVIRONMENT != 0;
            return if seen {
                environment_along(scene, ray, choice.at.gathers, &arrival, λ)
            } else {
                Spectrum::ZERO
            };
        };
        let (shape, point) = scene.surface::<F>(ray, &hit);
        let Some(index) = shape.emitter else { return Spectrum::ZERO };
        let met = Met { ray, t: hit.t, shape, point: &point, emitter: index as usize };
        met.weighted(scene, choice, &arrival, λ)
    }
}
