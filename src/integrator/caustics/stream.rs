//! Light paths in streams that take each step together.

use super::Caustics;
use super::connections::Connections;
use super::light_path::{Landing, LightPath, Splat};
use crate::integrator::Counters;
use crate::integrator::MAX_VERTICES;
use crate::integrator::wavefront::{Arrived, STREAM, Wavefront};
use crate::sampler::{ManyNumbers, PAIRS, RandomSource, Sampler, blocks};
use crate::scene::{Features, Scene};
use crate::spectrum::Wavelengths;
use std::ops::Range;

/// Buffers of a stream of light paths, kept for the next.
#[derive(Default)]
struct Stream {
    samplers: Vec<Sampler>,
    numbers: ManyNumbers<STREAM>,
    /// The paths that began.
    paths: Vec<LightPath>,
    wavefront: Wavefront,
    connections: Connections,
}

impl Caustics {
    /// Traces the light paths with these numbers, counted over all samples, and passes their contributions to
    /// `splat`, in the order of their numbers.
    pub fn trace(
        &self,
        scene: &Scene,
        source: RandomSource,
        numbers: Range<u64>,
        wavelengths: impl Fn(f64) -> Wavelengths,
        counters: &mut Counters,
        mut splat: impl FnMut(u64, &Splat),
    ) {
        // Kernels of light paths differ in what they need of a surface; light paths never meet an
        // environment.
        let simple = scene.features().0 & Features::TEXTURED & !Features::ENVIRONMENT == 0;
        let mut stream = Stream::default();
        for first in numbers.clone().step_by(STREAM) {
            let some = first..numbers.end.min(first + STREAM as u64);
            stream.samplers.clear();
            stream.samplers.extend(some.map(|number| source.light_path(number)));
            if simple {
                self.trace_stream::<{ Features::CAUSTICS }>(scene, &wavelengths, &mut stream, counters);
            } else {
                self.trace_stream::<{ Features::ALL }>(scene, &wavelengths, &mut stream, counters);
            }
            stream.connections.hand_on(|index, found| splat(first + index as u64, found));
        }
    }

    fn trace_stream<const F: u32>(
        &self,
        scene: &Scene,
        wavelengths: &impl Fn(f64) -> Wavelengths,
        Stream { samplers, numbers, paths, wavefront, connections }: &mut Stream,
        counters: &mut Counters,
    ) {
        let count = samplers.len();
        numbers.fill(count, PAIRS, |i| (&samplers[i], blocks::START));
        paths.clear();
        wavefront.begin((0..count).filter_map(|i| {
            let u = numbers.of(i);
            let (path, ray) = LightPath::begin(self, scene, i, u, wavelengths(u.light_wavelengths()))?;
            paths.push(path);
            Some((paths.len() - 1, ray))
        }));
        for edges in 1..=MAX_VERTICES {
            let going = wavefront.trace(scene, counters);
            if going.is_empty() {
                return;
            }
            numbers.fill(going.len(), PAIRS, |i| (&samplers[paths[going[i]].index], blocks::vertex(edges)));
            wavefront.advance(|Arrived { place, path, ray, hit }| {
                let landing = Landing { ray, hit: hit?, edges, u: numbers.of(place) };
                self.step::<F>(scene, &mut paths[path], landing, connections, counters)
            });
            connections.resolve(scene, counters);
        }
        counters.cut += wavefront.len() as u64;
    }
}
