//! How often `--target-error` reaches its target, and how often the confidence intervals from the standard
//! errors that a render prints contain the true value, over many seeds and several scenes. The true value is the
//! mean over all seeds.
//!
//! ```sh
//! cargo run --release --example attainment
//! cargo run --release --example attainment -- --runs 200 --target 2% scenes/prism.xml
//! ```

use clap::Parser;
use etalon::film::BLOCK;
use etalon::load;
use etalon::render::quality::Quality;
use etalon::render::sample_count::{Pilot, for_error};
use etalon::render::{Progress, Settings, render};
use etalon::scene::{Overrides, Scene};
use etalon::spectrum::ColorMode;
use std::error::Error;
use std::path::PathBuf;

const SCENES: [&str; 10] = [
    "scenes/cornell-spheres.xml",
    "scenes/cornell-glossy.xml",
    "scenes/lens-row.xml",
    "scenes/prism.xml",
    "scenes/assignment/spheres.xml",
    "scenes/convergence/small-light.xml",
    "scenes/convergence/inside-glass.xml",
    "validation/references/scenes/textures.xml",
    "validation/references/scenes/envmap.xml",
    "validation/references/scenes/roughdielectric.xml",
];

#[derive(Parser)]
struct Arguments {
    /// Scenes, instead of those of the repository
    scenes: Vec<PathBuf>,
    /// Seeds of each scene
    #[arg(long, default_value_t = 200)]
    runs: u32,
    /// Relative standard error that is asked for, in percent
    #[arg(long, default_value = "1%", value_parser = percent)]
    target: f64,
    /// Width of the film; its height is three quarters of it
    #[arg(long, default_value_t = 32)]
    width: u32,
    /// Instead of the scene's
    #[arg(long)]
    sampler: Option<String>,
    /// So many pixels share
    #[arg(long)]
    reuse: Option<u32>,
}

fn percent(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.strip_suffix('%').and_then(|n| n.parse().ok());
    number.filter(|n| *n > 0.0).map(|n| n / 100.0).ok_or("expected such as 1%".into())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let scenes = if arguments.scenes.is_empty() {
        SCENES.iter().map(|scene| root.join(scene)).collect()
    } else {
        arguments.scenes
    };
    println!(
        "| scene | samples | pilot | attained | within 1.96 of it | true error / asked for | printed / true | \
         heavy tails announced | by events | 95 % of means | 95 % of pixels |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for path in scenes {
        let size = Some((arguments.width, (arguments.width * 3 / 4).max(1)));
        let (sampler, reuse) = (arguments.sampler.clone(), arguments.reuse);
        let overrides = Overrides { size, sampler, reuse, ..Overrides::default() };
        let scene = load(&path, &[], ColorMode::Spectral, &overrides)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let runs: Result<Vec<Run>, String> =
            (0..arguments.runs).map(|seed| run(&scene, seed, arguments.target)).collect();
        match runs {
            Ok(runs) => println!("| {name} {}", row(&runs, arguments.target)),
            Err(why) => println!("| {name} | {why} |"),
        }
    }
    Ok(())
}

/// The result of one seed: the pilot, and the image with the number of samples that it chose.
struct Run {
    pilot: Pilot,
    quality: Quality,
    /// Mean and variance of the green channel of each pixel.
    green: Vec<(f64, f64)>,
}

fn run(scene: &Scene, seed: u32, target: f64) -> Result<Run, String> {
    let settings = Settings { seed, ..Settings::of(scene, 0..BLOCK) };
    let progress = Progress::default();
    let pilot = for_error(scene, &settings, target, &progress).map_err(|why| format!("{why:?}"))?;
    let settings = Settings { samples: 0..pilot.count, ..settings };
    let (image, report) = render(scene, &settings, &progress).map_err(|e| e.to_string())?;
    let green = image.channel("G").ok_or("no green")?;
    let variance = green.variance.as_ref().ok_or("no variance")?;
    let green = green.mean.iter().zip(variance).map(|(&m, &v)| (f64::from(m), f64::from(v))).collect();
    Ok(Run { pilot, quality: report.quality.ok_or("no samples")?, green })
}

fn row(runs: &[Run], target: f64) -> String {
    let count = runs.len() as f64;
    let share =
        |holds: &dyn Fn(&Run) -> bool| 100.0 * runs.iter().filter(|r| holds(r)).count() as f64 / count;
    let attained = share(&|r| r.quality.relative_standard_error_of_mean <= target);
    let announced = share(&|r| r.pilot.quality.heavy_tailed() || r.quality.heavy_tailed());
    let few = share(&|r| few_events(&r.green));
    let centre: [f64; 3] =
        std::array::from_fn(|c| runs.iter().map(|r| r.quality.mean[c]).sum::<f64>() / count);
    let scale = centre.iter().sum::<f64>() / 3.0;
    let error = |r: &Run, c: usize| (r.quality.mean[c] - centre[c]).abs() / scale;
    // What is printed is the root of the mean square over channels, so all three are asked.
    let of_channels =
        |holds: &dyn Fn(&Run, usize) -> bool| (0..3).map(|c| share(&|r| holds(r, c))).sum::<f64>() / 3.0;
    let printed = |r: &Run| r.quality.relative_standard_error_of_mean;
    let within = of_channels(&|r, c| error(r, c) <= NORMAL_95 * target);
    let held = of_channels(&|r, c| error(r, c) <= NORMAL_95 * printed(r));
    let squares = |r: &Run| (0..3).map(|c| error(r, c) * error(r, c)).sum::<f64>() / 3.0;
    let true_error = (runs.iter().map(squares).sum::<f64>() / (count - 1.0)).sqrt();
    let told = (runs.iter().map(|r| printed(r) * printed(r)).sum::<f64>() / count).sqrt();
    let mut counts: Vec<u64> = runs.iter().map(|r| r.pilot.count).collect();
    counts.sort_unstable();
    let pilots = runs.iter().map(|r| r.pilot.samples as f64 / r.pilot.count as f64).sum::<f64>() / count;
    format!(
        "| {} to {} | {:.0} % | {attained:.1} % | {within:.1} % | {:.2} | {:.2} | {announced:.0} % | {few:.0} % | {held:.1} % | {:.1} % |",
        counts[0],
        counts[counts.len() - 1],
        100.0 * pilots,
        true_error / target,
        told / true_error,
        100.0 * pixel_coverage(runs)
    )
}

/// Another indicator of heavy tails. In a pixel whose light came in k equal blocks, the variance of the mean
/// is about mean²/k: a pixel of few events is one whose standard error is as large as its value. Only such
/// variances can be far off, and they count as heavy-tailed where fewer than [`FEW`] of them would make an
/// equally uncertain sum.
fn few_events(pixels: &[(f64, f64)]) -> bool {
    let sum: f64 = pixels.iter().map(|p| p.1).sum();
    let uncertain =
        |&(mean, v): &(f64, f64)| if v > 0.0 { v * v * (v / (mean * mean)).min(1.0) } else { 0.0 };
    pixels.iter().map(uncertain).sum::<f64>() * FEW > sum * sum
}

/// The threshold of `etalon::render::pilot`.
const FEW: f64 = 20.0;

const NORMAL_95: f64 = 1.959_963_984_540_054;

/// The share of values whose 95 % interval contains the mean of all.
fn coverage(values: &[(f64, f64)]) -> f64 {
    let truth = values.iter().map(|v| v.0).sum::<f64>() / values.len() as f64;
    let held = |v: &&(f64, f64)| (v.0 - truth).abs() <= NORMAL_95 * v.1.sqrt();
    values.iter().filter(held).count() as f64 / values.len() as f64
}

/// The same share for each pixel, averaged over those that are not constant.
fn pixel_coverage(runs: &[Run]) -> f64 {
    let pixels = (0..runs[0].green.len()).map(|i| runs.iter().map(|r| r.green[i]).collect::<Vec<_>>());
    let noisy: Vec<_> = pixels.filter(|values| values.iter().any(|v| v.1 > 0.0)).collect();
    noisy.iter().map(|values| coverage(values)).sum::<f64>() / noisy.len() as f64
}
