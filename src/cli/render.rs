//! `etalon render`

use super::size::{parse_samples, parse_window};
use super::{Outcome, SceneArguments, peak_memory};
use etalon::image::{self, Image, Window};
use etalon::render::{Progress, Report, Settings, render};
use etalon::scene::Scene;
use indicatif::{ProgressBar, ProgressStyle};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Renders a scene to an OpenEXR file
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// OpenEXR file to write
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Also write an 8-bit picture
    #[arg(long, value_name = "OUT.png")]
    png: Option<PathBuf>,
    /// Samples a pixel, instead of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "samples")]
    spp: Option<u32>,
    /// Only these samples of every pixel; the file can be merged with others
    #[arg(long, value_name = "A..B", value_parser = parse_samples)]
    samples: Option<Range<u64>>,
    /// Only this part of the film
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_window)]
    crop: Option<Window>,
    /// Threads; one for each processor by default
    #[arg(long, value_name = "T", default_value_t = 0)]
    threads: usize,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Print a JSON document about the render to standard output
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Outcome {
        let start = Instant::now();
        let scene = self.scene.load()?;
        let load_seconds = start.elapsed().as_secs_f64();
        let settings = self.settings(&scene)?;
        [Some(&self.output), self.png.as_ref()]
            .into_iter()
            .flatten()
            .try_for_each(|path| require_place(path))?;
        let start = Instant::now();
        let (image, report) = self.watched(&scene, &settings).ok_or("the render was stopped")?;
        let seconds = start.elapsed().as_secs_f64();
        image::write_exr(&self.output, &image)?;
        if let Some(path) = &self.png {
            let (picture, _) = image::develop(&image)?;
            image::write_png(path, &picture)?;
        }
        let quality = Quality::of(&image);
        if self.json {
            println!("{}", summary(&scene, &settings, &report, &quality, seconds, load_seconds));
        } else if !self.quiet {
            print(&report, &quality, seconds, load_seconds);
        }
        self.report_non_finite(&report);
        Ok(ExitCode::from(u8::from(report.non_finite > 0)))
    }

    fn settings(&self, scene: &Scene) -> Result<Settings, String> {
        let film = &scene.sensor.film;
        let window = self.crop.unwrap_or(film.crop);
        let inside = window.x >= film.crop.x
            && window.y >= film.crop.y
            && u64::from(window.x) + u64::from(window.width) <= u64::from(film.crop.x + film.crop.width)
            && u64::from(window.y) + u64::from(window.height) <= u64::from(film.crop.y + film.crop.height);
        if !inside {
            let c = film.crop;
            let place = format!("{},{},{},{}", c.x, c.y, c.width, c.height);
            return Err(format!("error: --crop is not inside the film's {place}"));
        }
        let all = 0..u64::from(self.spp.unwrap_or(scene.sensor.sampler.samples));
        Ok(Settings {
            samples: self.samples.clone().unwrap_or(all),
            seed: scene.sensor.sampler.seed,
            window,
            threads: self.threads,
            shard: self.samples.is_some(),
            kernel: None,
        })
    }

    /// Renders with a progress bar beside it.
    fn watched(&self, scene: &Scene, settings: &Settings) -> Option<(Image, Report)> {
        let progress = Progress::default();
        if self.quiet || self.json {
            return render(scene, settings, &progress);
        }
        let pixels = settings.window.pixels() as u64;
        let bar = ProgressBar::new(pixels * (settings.samples.end - settings.samples.start));
        let template = "{bar:40} {percent:>3} %  {elapsed} elapsed, {eta} to go  {per_sec}";
        bar.set_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar()));
        std::thread::scope(|threads| {
            let worker = threads.spawn(|| render(scene, settings, &progress));
            while !worker.is_finished() {
                bar.set_position(progress.done.load(Ordering::Relaxed));
                std::thread::sleep(Duration::from_millis(50));
            }
            bar.finish_and_clear();
            worker.join().ok().flatten()
        })
    }

    fn report_non_finite(&self, report: &Report) {
        if report.cut > 0 {
            eprintln!(
                "warning: {} paths were cut at {} vertices",
                report.cut,
                etalon::integrator::path::MAX_VERTICES
            );
        }
        if report.non_finite == 0 {
            return;
        }
        eprintln!("warning: {} samples are not finite; the first:", report.non_finite);
        for found in &report.first_non_finite {
            let ((x, y), sample) = (found.pixel, found.sample);
            eprintln!("  etalon replay {} --pixel {x},{y} --sample {sample}", self.scene.scene.display());
        }
    }
}

/// Refuses a file that could not be written, before hours of rendering and not after.
fn require_place(path: &Path) -> Result<(), String> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(format!(
            "error: cannot write {}: there is no folder {}",
            path.display(),
            folder.display()
        ));
    }
    if path.is_dir() {
        return Err(format!("error: cannot write {}: it is a folder", path.display()));
    }
    Ok(())
}

/// How good an image is, over its first three channels.
struct Quality {
    mean: [f64; 3],
    /// Root mean square over pixels of the standard error, relative to the image's mean.
    relative_standard_error: f64,
    /// Standard error of the image's mean, relative to it.
    relative_standard_error_of_mean: f64,
}

impl Quality {
    fn of(image: &Image) -> Self {
        let n = image.crop.pixels() as f64;
        let sum = |values: &[f32]| values.iter().map(|&v| v as f64).sum::<f64>();
        let mut mean = [0.0; 3];
        let mut variance = 0.0;
        for (m, channel) in mean.iter_mut().zip(&image.channels) {
            *m = sum(&channel.mean) / n;
            variance += channel.variance.as_deref().map_or(f64::INFINITY, sum) / n;
        }
        let scale = mean.iter().sum::<f64>() / 3.0;
        let relative = (variance / 3.0).sqrt() / scale;
        Self { mean, relative_standard_error: relative, relative_standard_error_of_mean: relative / n.sqrt() }
    }
}

fn print(report: &Report, quality: &Quality, seconds: f64, load_seconds: f64) {
    let million = |count: u64| count as f64 / seconds / 1e6;
    let [r, g, b] = quality.mean;
    println!(
        "{:.2} s rendering, {load_seconds:.2} s loading, {} threads, kernel `{}`",
        seconds, report.threads, report.kernel
    );
    println!("{:.3} million paths/s, {:.2} million rays/s", million(report.samples), million(report.rays));
    println!("mean ({r:.5}, {g:.5}, {b:.5})");
    println!("relative standard error {:.3} % a pixel", 100.0 * quality.relative_standard_error);
    println!("relative standard error {:.4} % of the mean", 100.0 * quality.relative_standard_error_of_mean);
}

fn summary(
    scene: &Scene,
    settings: &Settings,
    report: &Report,
    quality: &Quality,
    seconds: f64,
    load_seconds: f64,
) -> serde_json::Value {
    serde_json::json!({
        "seconds": seconds,
        "load_seconds": load_seconds,
        "samples": report.samples,
        "samples_per_pixel": settings.samples.end - settings.samples.start,
        "rays": report.rays,
        "kernel": report.kernel,
        "threads": report.threads,
        "peak_memory_bytes": peak_memory(),
        "mean": quality.mean,
        "relative_standard_error": quality.relative_standard_error,
        "relative_standard_error_of_mean": quality.relative_standard_error_of_mean,
        "non_finite_samples": report.non_finite,
        "cut_paths": report.cut,
        "color": scene.mode.name(),
        "integrator": scene.integrator.name(),
        "scene_hash": scene.hash,
        "seed": settings.seed,
        "version": env!("CARGO_PKG_VERSION"),
    })
}
