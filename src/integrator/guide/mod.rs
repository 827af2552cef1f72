//! Guided emitter samples: along specular chains, in directions from which light paths have come.
//!
//! Where a surface is seen through glass or in a mirror, and lit through others, no light path can be
//! connected with the camera, and a [link](super::links) is found only if few surfaces lie between and they
//! lie on the straight line. Scattering finds such light by chance. But light paths know from where it comes:
//! before the render some leave the emitters, aimed at what is specular ([`Emission`]), and each that comes
//! by specular surfaces to one that scatters with a density leaves a photon there. Space is halved until few
//! photons are in a cell, and the directions of these, weighted by their power, are a density g(ω) (path
//! guiding by photons: Jensen 1995; Vorba et al. 2014).
//!
//! **The technique.** At a vertex one direction is drawn from g and followed from one specular surface to the
//! next, each time by a lobe that is sampled as on a path. If it comes to an emitter, by at least one such
//! surface, that is an estimate of the light that scattering finds as well, by the same lobes with the same
//! probabilities; so its MIS weight is that of the power heuristic, of g(ω) and the density p(ω) of
//! scattering. What g does not cover is left to scattering, so however few or wrong photons are, nothing is
//! biased.
//!
//! Photons are a function of the scene alone: every part of a render guides alike.

mod directions;
mod photons;

use super::Counters;
use super::caustics::Emission;
use super::mis::power_heuristic;
use super::vertex::Vertex;
use crate::bsdf::{Bsdf, Sample};
use crate::math::{DVec2, DVec3, Ray, bounds};
use crate::sampler::{Sampler, blocks};
use crate::scene::{Features, Scene, Side};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
pub use directions::Directions;
pub use photons::Photon;
use photons::photon;
use rayon::prelude::*;

/// Most surfaces of a specular chain that is guided; longer ones are left to scattering.
pub const LONGEST_CHAIN: u32 = 32;

// Each of them takes a number, after two for the direction.
const _: () = assert!(LONGEST_CHAIN + 2 < 8 * blocks::GUIDED_OF_VERTEX);

/// Cells with more photons are halved.
const MOST_PHOTONS: usize = 512;

/// The directions from which light comes by specular surfaces, as a density for each cell of space.
#[derive(Debug)]
pub struct Guide {
    /// Nodes of the tree; the first is the whole of space.
    cells: Vec<Cell>,
}

/// A part of space.
#[derive(Debug)]
enum Cell {
    /// Divided along `axis`: below the coordinate `at`, and not below.
    Halves {
        axis: usize,
        at: f64,
        further: [u32; 2],
    },
    Seen(Directions),
}

impl Guide {
    /// `None` without photons.
    pub fn new(mut photons: Vec<Photon>) -> Option<Self> {
        let mut cells = vec![];
        (!photons.is_empty()).then(|| {
            halve(&mut photons, &mut cells);
            Self { cells }
        })
    }

    /// The directions from which light comes, in the cell of a point.
    pub fn at(&self, p: DVec3) -> &Directions {
        let mut index = 0;
        loop {
            match &self.cells[index as usize] {
                Cell::Halves { axis, at, further } => index = further[usize::from(p[*axis] >= *at)],
                Cell::Seen(directions) => return directions,
            }
        }
    }
}

/// A guided emitter sample.
pub struct GuidedSample<'a> {
    pub directions: &'a Directions,
    pub sampler: &'a Sampler,
    /// Vertices before the one where it is taken.
    pub depth: u32,
    /// Most specular surfaces on its way.
    pub most: u32,
}

/// Takes a guided emitter sample: the radiance that leaves the vertex, with its MIS weight.
pub fn sample_guided<B: Bsdf>(
    scene: &Scene,
    vertex: &Vertex<B>,
    GuidedSample { directions, sampler, depth, most }: GuidedSample,
    λ: &Wavelengths,
    counters: &mut Counters,
) -> Spectrum {
    counters.guided += 1;
    // Eight numbers at a time: two for the direction, then one for each surface.
    let block = |which: u32| sampler.block(blocks::guided(depth, which));
    let mut u = block(0);
    let mut found = Spectrum::ZERO;
    let (w, density) = directions.sample(u.pair(0));
    let scattered = vertex.bsdf.evaluate(vertex.wo, vertex.to_local(w));
    if scattered.value.is_zero() {
        return found;
    }
    let weight = power_heuristic(density, scattered.pdf) / density;
    let mut throughput = scattered.value * weight as f32;
    let mut ray = vertex.point.ray(w, f64::INFINITY, vertex.primitive);
    for surfaces in 0..=most.min(LONGEST_CHAIN) {
        counters.rays += 1;
        let Some(hit) = scene.accel.closest(&ray) else { break };
        let (shape, point) = scene.surface::<{ Features::ALL }>(&ray, &hit);
        if let Some(emitter) = shape.emitter.filter(|_| surfaces > 0) {
            let emitter = &scene.emitters.list[emitter as usize].emitter;
            found += throughput * emitter.surface_radiance(&point, -ray.direction, λ);
        }
        let side = shape.side_towards(point.ns.dot(-ray.direction));
        if side.traits.has_density {
            break;
        }
        let number = surfaces + 2;
        if number % 8 == 0 {
            u = block(number / 8);
        }
        let lobe = u.one(number as usize % 8);
        let turn = onward(scene, -ray.direction, side, &point, hit.primitive, lobe, λ);
        let Some(turn) = turn else { break };
        throughput *= turn.sample.weight;
        ray = turn.ray;
    }
    found
}

/// Scattering at a specular surface.
struct Turn {
    /// Direction to where the path came from (local).
    wo: DVec3,
    sample: Sample,
    /// The path's next ray.
    ray: Ray,
}

/// Scatters by the lobe that a number in [0, 1) chooses; `None` if the path ends or the wavelengths separate.
fn onward(
    scene: &Scene,
    back: DVec3,
    side: &Side,
    point: &SurfacePoint,
    primitive: u32,
    lobe: f64,
    λ: &Wavelengths,
) -> Option<Turn> {
    let frame = side.frame::<{ Features::ALL }>(point);
    let wo = frame.to_local(back);
    let sample = scene.materials[side.material as usize].at(point, λ).sample(wo, lobe, DVec2::ZERO);
    let sample = sample.filter(|sample| !sample.dispersed)?;
    let ray = point.ray(frame.to_world(sample.wi), f64::INFINITY, primitive);
    Some(Turn { wo, sample, ray })
}

/// The photons of so many light paths.
pub fn photons(scene: &Scene, emission: &Emission, light_paths: u32) -> Vec<Photon> {
    (0..light_paths).into_par_iter().filter_map(|number| photon(scene, emission, number)).collect()
}

/// Adds the cell of these photons, halved as long as there are too many; returns its index.
fn halve(photons: &mut [Photon], cells: &mut Vec<Cell>) -> u32 {
    let index = cells.len();
    let (lo, hi) = bounds::around(photons.iter().map(|photon| photon.p));
    let axis = (hi - lo).max_position();
    if photons.len() <= MOST_PHOTONS || lo[axis] == hi[axis] {
        cells.push(Cell::Seen(Directions::new(photons.iter().map(|photon| (photon.w, photon.power)))));
        return index as u32;
    }
    photons.sort_by(|a, b| a.p[axis].total_cmp(&b.p[axis]));
    let (below, others) = photons.split_at_mut(photons.len() / 2);
    let at = others[0].p[axis];
    cells.push(Cell::Halves { axis, at, further: [0; 2] });
    let halves = [halve(below, cells), halve(others, cells)];
    if let Cell::Halves { further, .. } = &mut cells[index] {
        *further = halves;
    }
    index as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_the_photons_of_their_place() {
        // Light comes to the west from below and to the east from above, by more photons than a cell holds of
        // each, and many in one place.
        let photon = |i: usize| {
            let x = if i.is_multiple_of(3) { 0.25 } else { i as f64 / 3000.0 - 0.5 };
            Photon { p: DVec3::new(x, 0.0, 0.0), w: DVec3::Z * x.signum(), power: 1.0, left: 1.0 }
        };
        let guide = Guide::new((0..3000).map(photon).collect()).expect("there are photons");
        for (x, w) in [(-0.4, -DVec3::Z), (0.4, DVec3::Z), (-9.0, -DVec3::Z), (9.0, DVec3::Z)] {
            let seen = guide.at(DVec3::new(x, 7.0, -7.0));
            assert!(seen.density(w) > 1.0, "{x}");
            assert_eq!(seen.density(-w), 0.0, "{x}");
        }
        assert!(Guide::new(vec![]).is_none());
    }
}
