//! Who computes what, and when. What the scene's file leaves open is settled first, as a function of the scene
//! alone ([`plan`]). Then every sample is a function of the scene, the seed, its pixel and its number
//! ([`sample`], `splats`, [`spread`]), and samples add up in an order that does not matter
//! ([`crate::film`]): nothing else here can change a pixel.

mod bits;
pub mod checkpoint;
mod error;
pub mod history;
pub mod law;
pub mod light_path_noise;
pub mod memory;
pub mod passes;
pub mod plan;
pub mod preview;
pub mod quality;
mod replay;
pub mod sample;
pub mod sample_count;
mod splats;
pub mod spread;
pub mod squares;
mod tile;

use crate::film::BLOCK;
use crate::film::Window;
use crate::image::{Channel, Image, Provenance, single_variance};
use crate::integrator::{Counters, KernelEntry, kernel_for};
use crate::sampler::SampleId;
use crate::scene::Scene;
pub use error::RenderError;
use history::{History, Notes};
use law::Law;
use light_path_noise::Excess;
use passes::{Partial, render_passes};
use quality::{Correlation, Noise, Quality};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use sample::SampleMaker;
use splats::Splats;
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicU64};
use tile::Tile;

/// Edge of the square tiles that threads take, in pixels.
const TILE: u32 = 16;

/// What to render of a scene.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Numbers of the samples of every pixel; must begin at a multiple of [`BLOCK`].
    pub samples: Range<u64>,
    pub seed: u32,
    /// Pixels of the film.
    pub window: Window,
    /// Number of threads; 0 means one for each processor.
    pub threads: usize,
    /// Keep the exact sums, so that the image can be merged with others.
    pub shard: bool,
    /// Run this kernel instead of the least sufficient one.
    pub kernel: Option<&'static KernelEntry>,
}

impl Settings {
    /// These samples of all that the scene's film shows, by the scene's seed, on one thread.
    pub fn of(scene: &Scene, samples: Range<u64>) -> Self {
        let sensor = &scene.sensor;
        let (seed, window) = (sensor.sampler.seed, sensor.film.crop);
        Self { samples, seed, window, threads: 1, shard: false, kernel: None }
    }

    /// The kernel that renders a scene.
    fn kernel(&self, scene: &Scene) -> &'static KernelEntry {
        self.kernel.unwrap_or_else(|| kernel_for(scene.features()))
    }
}

/// What a render did besides making an image.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Camera samples.
    pub samples: u64,
    pub rays: u64,
    /// Paths cut at the hard limit of vertices.
    pub cut: u64,
    pub non_finite: u64,
    /// The first few samples whose value is infinite or not a number, in order of pixel and sample.
    pub first_non_finite: Vec<SampleId>,
    pub kernel: &'static str,
    pub threads: usize,
    /// Quality of the whole image, from more digits than a file has.
    pub quality: Option<Quality>,
}

impl Report {
    /// Adds the report of another part.
    fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.rays += other.rays;
        self.cut += other.cut;
        self.non_finite += other.non_finite;
        self.first_non_finite.extend(&other.first_non_finite);
    }

    /// Adds what was counted along paths.
    fn count(&mut self, counters: &Counters) {
        self.rays += counters.rays;
        self.cut += counters.cut;
    }

    /// Keeps of the non-finite samples the first in order of pixel and sample.
    fn list_first(&mut self) {
        self.first_non_finite.sort_by_key(|n| (n.pixel.1, n.pixel.0, n.sample));
        self.first_non_finite.truncate(LISTED);
    }
}

/// Shared between a render and whoever watches it.
#[derive(Debug, Default)]
pub struct Progress {
    /// Camera samples that are done.
    pub done: AtomicU64,
    /// Set to stop early; the render then ends with [`RenderError::Stopped`].
    pub stop: AtomicBool,
}

/// How many non-finite samples are listed.
const LISTED: usize = 8;

/// Does some work with so many threads; 0 means one for each processor.
///
/// # Errors
/// If they cannot be started.
pub fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T, RenderError> {
    pool(threads).map(|pool| pool.install(work))
}

fn pool(threads: usize) -> Result<ThreadPool, RenderError> {
    let refused =
        |error: ThreadPoolBuildError| RenderError::Threads { count: threads, why: error.to_string() };
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(refused)
}

/// Renders.
///
/// # Errors
/// If `progress` was told to stop, or if the threads cannot be started.
pub fn render(
    scene: &Scene,
    settings: &Settings,
    progress: &Progress,
) -> Result<(Image, Report), RenderError> {
    debug_assert_eq!(settings.samples.start % BLOCK, 0);
    // Exact sums are needed in the end, or light paths or samples of other pixels for as many samples as are
    // held at a time.
    if settings.shard || scene.techniques.caustics.is_some() || scene.sensor.film.spread.is_some() {
        let begun = Partial::new(scene, settings);
        let done = render_passes(scene, settings, begun, progress, |_| ControlFlow::Continue(()))?;
        return Ok(done.finished(scene, settings));
    }
    let kernel = settings.kernel(scene);
    let maker = SampleMaker::new(scene, settings.seed, kernel);
    let names = maker.channel_names();
    let pool = pool(settings.threads)?;
    let windows: Vec<Window> = settings.window.tiles(TILE).collect();
    let (samples, correlation) = (&settings.samples, Correlation::of(scene));
    let history = History::of(scene, settings.window, samples.start);
    let mut history = history.map(|history| history.until(samples.end));
    let part = |window| {
        let mut tile = Tile::new(window, names.len());
        // Numbers of samples of which there may be sums: at least one sample, at most all.
        let numbers = samples.start + 1..samples.end + 1;
        let mut notes = history.as_ref().and_then(|history| history.notes(window, numbers));
        for some in notes.as_ref().map_or_else(|| vec![samples.clone()], |notes| notes.ranges(samples)) {
            tile.render(&maker, &Splats::default(), names.len(), &some, progress)?;
            notes.iter_mut().for_each(|notes| notes.add(some.end, &tile.sums));
        }
        Some(Part::of(tile, notes, names.len(), samples.end - samples.start, correlation))
    };
    let parts: Option<Vec<Part>> = pool.install(|| windows.into_par_iter().map(part).collect());
    let parts = parts.ok_or(RenderError::Stopped)?;
    let mut report = Report { kernel: kernel.name, threads: pool.current_num_threads(), ..Report::default() };
    let mut noise = Noise::default();
    for part in &parts {
        report.add(&part.report);
        noise.add(&part.noise);
        history.iter_mut().zip(&part.notes).for_each(|(history, notes)| history.take(notes));
    }
    report.list_first();
    let law = Law::of_render(scene, history.as_ref(), samples);
    report.quality = Some(noise.quality(settings.window, law, Excess::default()));
    let provenance = provenance(scene, settings, kernel);
    Ok((assemble(scene, settings.window, names, &parts, provenance), report))
}

/// What is kept of a tile to whose sums no more samples will be added: sums are large.
struct Part {
    window: Window,
    /// Mean and variance, pixel by pixel, channel by channel.
    moments: Vec<(f32, f32)>,
    noise: Noise,
    notes: Option<Notes>,
    report: Report,
}

impl Part {
    /// From a tile of so many channels and samples.
    fn of(tile: Tile, notes: Option<Notes>, channels: usize, count: u64, correlation: Correlation) -> Self {
        let Tile { window, sums, report } = tile;
        let channel = |c: usize| sums.iter().skip(c).step_by(channels);
        let exact = (0..channels).map(|c| channel(c).map(|s| (s.mean(count), s.variance(count))));
        let noise = Noise::of(window, correlation, exact);
        let moments =
            sums.iter().map(|s| (s.mean(count) as f32, single_variance(s.variance(count)))).collect();
        Self { window, moments, noise, notes, report }
    }
}

fn provenance(scene: &Scene, settings: &Settings, kernel: &KernelEntry) -> Provenance {
    Provenance {
        version: crate::VERSION.into(),
        scene: scene.hash.clone(),
        seed: settings.seed as u64,
        samples: settings.samples.clone(),
        kernel: kernel.name.into(),
        integrator: scene.integrator.name().into(),
        extra: Correlation::attributes(scene),
    }
}

/// Places the parts; each pixel comes from exactly one.
fn assemble(
    scene: &Scene,
    window: Window,
    names: Vec<String>,
    parts: &[Part],
    provenance: Provenance,
) -> Image {
    let empty = || vec![0.0f32; window.pixels()];
    let mut channels: Vec<Channel> =
        names.into_iter().map(|name| Channel { name, mean: empty(), variance: Some(empty()) }).collect();
    for part in parts {
        for (i, moments) in part.moments.chunks_exact(channels.len()).enumerate() {
            let Some(at) = window.index_of(part.window.pixel(i)) else { continue };
            for (channel, (mean, variance)) in channels.iter_mut().zip(moments) {
                channel.mean[at] = *mean;
                channel.variance.iter_mut().for_each(|v| v[at] = *variance);
            }
        }
    }
    let full = scene.sensor.film.size;
    Image { full, crop: window, channels, provenance: Some(provenance), accumulators: None }
}
