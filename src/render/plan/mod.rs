//! How a scene is to be rendered, where its file leaves that open.
//!
//! Pilots run one after another, for what each settles changes what the next sees: how many light paths there
//! are ([`light_paths`]), whether emitter samples are guided by photons ([`guide`]), and how many pixels
//! share what their paths find ([`reuse`]), which is last, and may undo the first. All of it is a function of
//! the scene alone, so every part of a render settles the same. Pilots have a seed of their own and their
//! samples are thrown away, so no choice can bias an image.

mod cells;
mod direct;
pub mod guide;
pub mod light_paths;
mod look;
mod race;
pub mod reuse;

use super::sample::SampleMaker;
use crate::film::Window;
use crate::integrator::kernel_for;
use crate::sampler::SampleId;
use crate::scene::Scene;
use crate::spectrum::observer::luminance;
use std::time::Instant;

/// Settles all that the scene's file leaves open.
pub fn settle(mut scene: Scene) -> Scene {
    let begin = Instant::now();
    light_paths::settle(&mut scene);
    guide::settle(&mut scene);
    reuse::settle(&mut scene);
    scene.planning = begin.elapsed();
    scene
}

/// The i-th of numbers spread evenly below `count`: multiples of the golden ratio leave no gaps.
fn scattered(i: u64, count: u64) -> u64 {
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    ((u128::from(i.wrapping_mul(GOLDEN)) * u128::from(count)) >> 64) as u64
}

/// What makes the samples of a pilot that settles how a scene is to be rendered. Its seed is unlikely to be an
/// image's, whose samples must not be those that have settled it.
fn pilot_maker(scene: &Scene) -> SampleMaker<'_> {
    const SEED: u32 = 0x5eed_ab1e;
    SampleMaker::new(scene, SEED, kernel_for(scene.features()))
}

/// So many samples of pixels spread evenly over a window, for a pilot.
fn all_over(window: Window, samples: u64) -> Vec<SampleId> {
    let at = |i: u64| window.pixel(scattered(i, window.pixels() as u64) as usize);
    (0..samples).map(|sample| SampleId { pixel: at(sample), sample }).collect()
}

/// The luminance of a sample, which stands for all its colours: that of any light is positive, while a single
/// channel may be black, or negative.
fn brightness(values: &[f64]) -> f64 {
    luminance([values[0], values[1], values[2]])
}
