//! A render in passes over the whole window, after each of which it can be saved, shown or ended.
//!
//! A pass is a range of samples whose length is a power of two times [`BLOCK`] and whose beginning is a
//! multiple of that length. The sums are exact, so that neither the division into passes nor the order in
//! which tiles arrive can change a pixel: the clock may decide how long a pass is.

use super::history::History;
use super::light_path_noise::LightPathNoise;
use super::quality::Quality;
use super::spread::Spread;
use super::tile::Tile;
use super::{Progress, RenderError, Report, Settings, TILE, provenance};
use crate::film::Window;
use crate::film::{Accumulators, BLOCK};
use crate::image::{Channel, Image};
use crate::render::sample::SampleMaker;
use crate::render::splats::{self, Splats};
use crate::scene::Scene;
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Passes grow until they take about this long.
const PASS: Duration = Duration::from_millis(500);

/// A render up to some sample.
#[derive(Clone, Debug)]
pub struct Partial {
    /// Numbers of the samples that every pixel has.
    pub samples: Range<u64>,
    /// Names of the channels.
    pub channels: Vec<String>,
    /// The exact sums, pixel by pixel of the window.
    pub sums: Accumulators,
    /// What parts of the image have come to on the way, if that tells more than the variances of pixels.
    pub history: Option<History>,
    /// What the errors of pixels have in common by light paths.
    pub light_paths: LightPathNoise,
    /// The report so far.
    pub report: Report,
}

impl Partial {
    /// A render that has not begun.
    pub fn new(scene: &Scene, settings: &Settings) -> Self {
        let channels = SampleMaker::new(scene, settings.seed, settings.kernel(scene)).channel_names();
        Self {
            samples: settings.samples.start..settings.samples.start,
            sums: Accumulators::new(settings.window.width, settings.window.height, channels.len()),
            channels,
            history: History::of(scene, settings.window, settings.samples.start),
            light_paths: LightPathNoise::default(),
            report: Report::default(),
        }
    }

    /// The image so far: bit for bit that of a render of these samples only.
    pub fn image(&self, scene: &Scene, settings: &Settings) -> Image {
        let so_far = Settings { samples: self.samples.clone(), ..settings.clone() };
        Image {
            full: scene.sensor.film.size,
            crop: settings.window,
            channels: Channel::all(&self.channels, &self.sums, self.samples.end - self.samples.start),
            provenance: Some(provenance(scene, &so_far, settings.kernel(scene))),
            accumulators: settings.shard.then(|| self.sums.clone()),
        }
    }

    /// The image, and the report of the render.
    pub fn finished(&self, scene: &Scene, settings: &Settings) -> (Image, Report) {
        let quality = Some(Quality::of(self, scene, settings.window));
        (self.image(scene, settings), Report { quality, ..self.report.clone() })
    }

    fn add(&mut self, window: Window, tile: &Tile) {
        for (i, sums) in tile.sums.chunks_exact(self.channels.len()).enumerate() {
            let (x, y) = tile.window.pixel(i);
            for (sum, part) in self.sums.pixel_mut(x - window.x, y - window.y).iter_mut().zip(sums) {
                sum.merge(part);
            }
        }
        self.report.add(&tile.report);
    }
}

/// Goes on with a render to the end of `settings.samples`, or until `after_pass` breaks.
///
/// # Errors
/// If `progress` was told to stop, which ends it in the middle of a pass, or if the threads cannot be started.
pub fn render_passes(
    scene: &Scene,
    settings: &Settings,
    partial: Partial,
    progress: &Progress,
    mut after_pass: impl FnMut(&Partial) -> ControlFlow<()>,
) -> Result<Partial, RenderError> {
    let kernel = settings.kernel(scene);
    let maker = SampleMaker::new(scene, settings.seed, kernel);
    let pool = super::pool(settings.threads)?;
    let windows: Vec<Window> = settings.window.tiles(TILE).collect();
    let mut partial = partial;
    (partial.report.kernel, partial.report.threads) = (kernel.name, pool.current_num_threads());
    let spreads = scene.sensor.film.spread.is_some();
    let mut spread = spreads.then(|| Spread::new(&maker, settings.window, partial.channels.len()));
    let mut longest = BLOCK;
    while partial.samples.end < settings.samples.end {
        let done = partial.samples.end;
        let step = partial.history.as_ref().map_or(longest, |history| history.longest_step(done));
        let pass = next_pass(done, settings.samples.end, longest.min(step));
        let begin = Instant::now();
        let channels = partial.channels.len();
        let splats = pool
            .install(|| Splats::trace(&maker, settings.window, &pass, progress))
            .ok_or(RenderError::Stopped)?;
        partial.report.count(&splats.counters);
        splats.noise.iter().for_each(|noise| partial.light_paths.add(noise));
        if let Some(spread) = &mut spread {
            let report = pool.install(|| spread.add(&pass, &splats, &mut partial.sums, progress));
            partial.report.add(&report.ok_or(RenderError::Stopped)?);
        } else {
            let shared = Mutex::new(&mut partial);
            let done = pool.install(|| {
                windows.par_iter().try_for_each(|&window| {
                    let mut tile = Tile::new(window, channels);
                    tile.render(&maker, &splats, channels, &pass, progress)?;
                    shared.lock().unwrap_or_else(PoisonError::into_inner).add(settings.window, &tile);
                    Some(())
                })
            });
            done.ok_or(RenderError::Stopped)?;
        }
        partial.report.list_first();
        partial.samples.end = pass.end;
        if let Some(history) = &mut partial.history {
            history.note(pass.end, settings.window, partial.sums.all());
        }
        let many = (pass.end - pass.start) * maker.light_paths() >= splats::MANY;
        if begin.elapsed() < PASS && !many && pass.end - pass.start == longest {
            longest *= 2;
        }
        if after_pass(&partial).is_break() {
            break;
        }
    }
    Ok(partial)
}

/// The pass that begins at sample `done`, a multiple of [`BLOCK`]: aligned, at most `longest`, and not beyond
/// the end.
fn next_pass(done: u64, end: u64, longest: u64) -> Range<u64> {
    let aligned = if done == 0 { longest } else { longest.min(1 << done.trailing_zeros()) };
    done..end.min(done + aligned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;
    use crate::render::render;
    use crate::spectrum::ColorMode;

    const SCENE: &str = r#"<scene version="3.0.0">
        <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="19"/><integer name="height" value="18"/></film></sensor>
        <shape type="sphere"><transform name="to_world"><translate z="4"/></transform></shape>
        <emitter type="constant"/></scene>"#;

    #[test]
    fn passes_are_aligned_and_leave_nothing_out() {
        for (start, end) in [(0, 4), (0, 1000), (4, 77), (96, 5000), (0, 3)] {
            let (mut done, mut longest) = (start, BLOCK);
            while done < end {
                let pass = next_pass(done, end, longest);
                let length = pass.end - pass.start;
                assert!(pass.start == done && length > 0 && length <= longest);
                assert!(
                    pass.end == end
                        || length.is_power_of_two() && done % length == 0 && length.is_multiple_of(BLOCK)
                );
                done = pass.end;
                longest *= 2;
            }
            assert_eq!(done, end);
        }
    }

    #[test]
    fn passes_give_the_image_of_one_run_at_every_end() {
        for (samples, shard, reuse) in [(0..45, false, 1), (8..61, true, 1), (0..45, false, 16)] {
            let sharing = format!(
                r#"<integrator type="path"><integer name="reuse" value="{reuse}"/></integrator><sensor "#
            );
            let text = SCENE.replace("<sensor ", &sharing);
            let scene = load_text("scene.xml", &text, ColorMode::Spectral).expect("it loads");
            let settings = Settings {
                samples,
                seed: 1,
                window: Window { x: 1, y: 0, width: 18, height: 17 },
                threads: 2,
                shard,
                kernel: None,
            };
            let progress = Progress::default();
            let mut ends = 0;
            let begun = Partial::new(&scene, &settings);
            let whole = render_passes(&scene, &settings, begun, &progress, |partial| {
                let (image, report) = (partial.image(&scene, &settings), &partial.report);
                let alone = Settings { samples: partial.samples.clone(), ..settings.clone() };
                let (expected, expected_report) =
                    render(&scene, &alone, &Progress::default()).expect("it renders");
                assert_eq!(image, expected);
                assert_eq!(report.rays, expected_report.rays);
                let count = (partial.samples.end - partial.samples.start) * settings.window.pixels() as u64;
                assert_eq!([report.samples, expected_report.samples], [count; 2]);
                ends += 1;
                ControlFlow::Continue(())
            });
            assert_eq!(whole.expect("it renders").samples, settings.samples);
            assert!(ends >= 4);
        }
    }

    #[test]
    fn a_render_can_be_ended_between_passes_and_stopped_within() {
        let scene = load_text("scene.xml", SCENE, ColorMode::Spectral).expect("it loads");
        let settings = Settings::of(&scene, 0..64);
        let progress = Progress::default();
        let begun = || Partial::new(&scene, &settings);
        let ended = render_passes(&scene, &settings, begun(), &progress, |_| ControlFlow::Break(()));
        assert_eq!(ended.map(|partial| partial.samples), Ok(0..BLOCK));
        progress.stop.store(true, std::sync::atomic::Ordering::Relaxed);
        let stopped = render_passes(&scene, &settings, begun(), &progress, |_| ControlFlow::Continue(()));
        assert_eq!(stopped.map(|_| ()), Err(RenderError::Stopped));
    }
}
