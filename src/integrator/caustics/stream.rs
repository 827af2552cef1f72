//! Light paths that take each step together.

use super::Caustics;
use super::light_path::{LightPath, Splat};
use crate::integrator::Counters;
use crate::integrator::path::MAX_VERTICES;
use crate::math::Ray;
use crate::sampler::{CAMERA, FIRST_VERTEX, Kind, ManyNumbers, PAIRS, Sampler};
use crate::scene::Scene;
use crate::shape::Hit;
use crate::spectrum::Wavelengths;
use std::ops::Range;

/// How many light paths are traced together.
const STREAM: usize = 64;

/// The column that stands for light paths where samplers are given a pixel: no film is as wide.
const LIGHT: u32 = u32::MAX;

/// What a stream of light paths needs on its way, kept for the next.
#[derive(Default)]
struct Stream {
    samplers: Vec<Sampler>,
    numbers: ManyNumbers<STREAM>,
    /// The paths that began, each with its place in the stream.
    paths: Vec<(usize, LightPath)>,
    /// Those that still go on, with their rays side by side.
    alive: Vec<usize>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    found: Vec<(usize, Splat)>,
}

impl Caustics {
    /// Traces light paths by their numbers, counted over all samples, and hands on what they bring to the
    /// film, in the order of their numbers.
    pub fn trace(
        &self,
        scene: &Scene,
        (kind, seed): (Kind, u32),
        numbers: Range<u64>,
        wavelengths: impl Fn(f64) -> Wavelengths,
        counters: &mut Counters,
        mut splat: impl FnMut(u64, Splat),
    ) {
        let mut stream = Stream::default();
        for first in numbers.clone().step_by(STREAM) {
            let sampler =
                |number: u64| Sampler::new(kind, seed, (LIGHT, (number >> 32) as u32), number as u32);
            stream.samplers.clear();
            stream.samplers.extend((first..numbers.end.min(first + STREAM as u64)).map(sampler));
            self.trace_stream(scene, &wavelengths, &mut stream, counters);
            // Each path's own are in order already, and stay so.
            stream.found.sort_by_key(|(index, _)| *index);
            stream.found.drain(..).for_each(|(index, found)| splat(first + index as u64, found));
        }
    }

    fn trace_stream(
        &self,
        scene: &Scene,
        wavelengths: &impl Fn(f64) -> Wavelengths,
        Stream { samplers, numbers, paths, alive, rays, hits, found }: &mut Stream,
        counters: &mut Counters,
    ) {
        let count = samplers.len();
        numbers.fill(count, PAIRS, |i| (&samplers[i], CAMERA));
        let begin = |i: usize| {
            let u = numbers.of(i);
            Some((i, LightPath::begin(self, scene, u, wavelengths(u.one(4)))?))
        };
        paths.clear();
        paths.extend((0..count).filter_map(begin));
        alive.clear();
        alive.extend(0..paths.len());
        rays.clear();
        rays.extend(paths.iter().map(|(_, path)| path.ray));
        hits.resize(STREAM, None);
        for edges in 1..=MAX_VERTICES {
            if alive.is_empty() {
                return;
            }
            counters.rays += rays.len() as u64;
            scene.accel.closest_all(rays, hits);
            numbers.fill(alive.len(), PAIRS, |i| (&samplers[paths[alive[i]].0], FIRST_VERTEX - 1 + edges));
            let mut kept = 0;
            for i in 0..alive.len() {
                let Some(hit) = hits[i] else { continue };
                let (index, path) = &mut paths[alive[i]];
                let splat = |splat| found.push((*index, splat));
                if let Some(ray) = self.step(scene, path, (edges, hit, numbers.of(i)), counters, splat) {
                    path.ray = ray;
                    (alive[kept], rays[kept]) = (alive[i], ray);
                    kept += 1;
                }
            }
            alive.truncate(kept);
            rays.truncate(kept);
        }
        counters.cut += alive.len() as u64;
    }
}
