//! The light paths whose photons guide emitter samples.

use super::{LONGEST_CHAIN, onward};
use crate::integrator::Counters;
use crate::integrator::caustics::Emission;
use crate::integrator::links::{SpecularChain, density_of};
use crate::integrator::mis::power_heuristic;
use crate::math::{DVec3, INV_PI, Origin};
use crate::sampler::{RandomSource, SamplerKind, blocks};
use crate::scene::{Features, Scene};

/// Light that has come by specular surfaces to one that scatters with a density.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    pub p: DVec3,
    /// Direction (world) to where it came from.
    pub w: DVec3,
    pub power: f64,
    /// Share of its light that is left to scattering, its MIS weight, if emitters are sampled by links.
    pub left: f64,
}

/// The photon of the light path with this number, if there is one.
pub fn photon(scene: &Scene, emission: &Emission, number: u32) -> Option<Photon> {
    let sampler = RandomSource { kind: SamplerKind::Sobol, seed: 0 }.photon(number);
    let u = sampler.block(blocks::START);
    let λ = scene.mode.wavelengths(u.light_wavelengths());
    let start = emission.sample(&scene.emitters, &scene.shapes, &u, &λ)?;
    // A lane might not hold the product.
    let (mut light, scale) = (start.radiance * λ.ones(), start.cos / start.density);
    let mut ray = start.ray;
    let mut chain = Some(SpecularChain::BEGUN);
    for edges in 1..=LONGEST_CHAIN + 1 {
        let hit = scene.accel.closest(&ray)?;
        let (shape, point) = scene.surface::<{ Features::ALL }>(&ray, &hit);
        let w = -ray.direction;
        let side = shape.side_towards(point.ns.dot(w));
        if side.traits.has_density {
            let power = f64::from(λ.mean(light)) * scale;
            let linked = chain.and_then(|chain| {
                let mut counters = Counters::default();
                let from = Origin { p: point.p, primitive: hit.primitive };
                let found = density_of(scene, from, w, chain, start.end, &λ, &mut counters)?;
                // As of a matte surface; for others it is not known in which direction they scatter.
                Some(found / (chain.chance * point.ng.dot(w).abs() * INV_PI))
            });
            let left = linked.map_or(1.0, |linked| power_heuristic(1.0, linked));
            let some = edges > 1 && power > 0.0 && power.is_finite();
            return some.then_some(Photon { p: point.p, w, power, left });
        }
        let number = sampler.block(blocks::vertex(edges)).lobe();
        let turn = onward(scene, w, side, &point, hit.primitive, number, &λ)?;
        chain = chain.and_then(|chain| chain.on(side, hit.primitive, turn.wo, &turn.sample));
        // Power, unlike radiance, does not change with the index.
        light *= turn.sample.weight * (turn.sample.eta * turn.sample.eta) as f32;
        ray = turn.ray;
    }
    None
}
