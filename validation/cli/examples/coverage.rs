//! How often the 95 % intervals from the standard errors contain the true value, and what other estimators
//! achieve: blocks of other lengths, Student's quantile instead of the normal one, the intervals of `validate
//! intervals`. The true value is the mean over all replicates.
//!
//! With `--printed`, of the error of the image's mean that a render prints instead.
//!
//! Every replicate is rendered in ranges of four samples, from whose means each estimator computes its
//! variance, so that all of them use the same pictures. Prints a line of JSON for every scene, sampler,
//! integrator and estimator:
//!
//! ```sh
//! cargo run --release -p validate --example coverage -- --replicates 2000 --spp 64 > coverage.jsonl
//! ```

use clap::Parser;
use etalon::film::BLOCK;
use etalon::load;
use etalon::render::quality::Quality;
use etalon::render::{Progress, Settings, render};
use etalon::scene::{Overrides, Scene};
use etalon::spectrum::ColorMode;
use std::error::Error;
use std::path::{Path, PathBuf};
use validation::image::half_widths;
use validation::statistics::distributions::student_quantile;

const SCENES: [&str; 11] = [
    "scenes/cornell-spheres.xml",
    "scenes/cornell-glossy.xml",
    "scenes/lens-row.xml",
    "scenes/prism.xml",
    "scenes/convergence/cornell-diffuse.xml",
    "scenes/convergence/interior.xml",
    "scenes/convergence/small-light.xml",
    "scenes/convergence/inside-glass.xml",
    "scenes/convergence/lens-caustics.xml",
    "validation/references/scenes/envmap.xml",
    "validation/references/scenes/roughdielectric.xml",
];

#[derive(Parser)]
struct Arguments {
    /// Scenes, instead of those of the repository
    scenes: Vec<PathBuf>,
    /// Pictures of each scene, sampler and integrator
    #[arg(long, default_value_t = 2000)]
    replicates: u32,
    /// Samples a pixel, a multiple of 16
    #[arg(long, default_value_t = 64)]
    spp: u64,
    /// Width of the film; its height is three quarters of it
    #[arg(long, default_value_t = 12)]
    width: u32,
    #[arg(long, value_delimiter = ',', default_values = ["sobol", "independent"])]
    samplers: Vec<String>,
    #[arg(long, value_delimiter = ',', default_values = ["path", "direct"])]
    integrators: Vec<String>,
    /// So many pixels share
    #[arg(long)]
    reuse: Option<u32>,
    /// Only what a render prints of the image's mean
    #[arg(long)]
    printed: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let scenes = if arguments.scenes.is_empty() {
        SCENES.iter().map(|scene| root.join(scene)).collect()
    } else {
        arguments.scenes.clone()
    };
    for path in &scenes {
        for sampler in &arguments.samplers {
            for integrator in &arguments.integrators {
                let overrides = Overrides {
                    size: Some((arguments.width, (arguments.width * 3 / 4).max(1))),
                    sampler: Some(sampler.clone()),
                    integrator: Some(integrator.clone()),
                    reuse: arguments.reuse.filter(|_| integrator == "path"),
                    ..Overrides::default()
                };
                let scene = load(path, &[], ColorMode::Spectral, &overrides)?;
                let name = path.file_stem().unwrap_or_default().to_string_lossy();
                let about =
                    format!("\"scene\":\"{name}\",\"sampler\":\"{sampler}\",\"integrator\":\"{integrator}\"");
                let judge = if arguments.printed { judge_printed } else { judge };
                judge(&about, &scene, &arguments)?;
            }
        }
    }
    Ok(())
}

/// Renders one replicate: for each pixel, the means of the green channel over its ranges of four samples.
fn replicate(scene: &Scene, seed: u32, spp: u64) -> Result<Vec<Vec<f64>>, String> {
    let window = scene.sensor.film.crop;
    let mut pixels = vec![vec![]; window.pixels()];
    for begin in (0..spp).step_by(BLOCK as usize) {
        let samples = begin..begin + BLOCK;
        let settings = Settings { seed, ..Settings::of(scene, samples) };
        let (image, _) = render(scene, &settings, &Progress::default()).map_err(|e| e.to_string())?;
        let green = image.channel("G").ok_or("no green")?;
        for (pixel, mean) in pixels.iter_mut().zip(&green.mean) {
            pixel.push(f64::from(*mean));
        }
    }
    Ok(pixels)
}

/// Of the image's mean, how often it lies where the error that a render prints says. That is the root of the mean square
/// over the three channels, so all of them are asked.
fn judge_printed(about: &str, scene: &Scene, arguments: &Arguments) -> Result<(), String> {
    let replicate = |seed| {
        let settings = Settings { seed, ..Settings::of(scene, 0..arguments.spp) };
        let (_, report) = render(scene, &settings, &Progress::default()).map_err(|e| e.to_string())?;
        report.quality.ok_or_else(|| "no samples".to_string())
    };
    let all: Result<Vec<Quality>, String> = (0..arguments.replicates).map(replicate).collect();
    let all = all?;
    let count = all.len() as f64;
    let truth: [f64; 3] = std::array::from_fn(|c| all.iter().map(|q| q.mean[c]).sum::<f64>() / count);
    let scale = truth.iter().sum::<f64>() / 3.0;
    let (mut held, mut variances) = (0u64, [0.0; 2]);
    for quality in &all {
        let printed = quality.relative_standard_error_of_mean;
        let errors = std::array::from_fn::<_, 3, _>(|c| (quality.mean[c] - truth[c]).abs() / scale);
        held += errors.iter().filter(|error| **error <= NORMAL_95 * printed).count() as u64;
        variances[0] += printed * printed;
        variances[1] += errors.iter().map(|error| error * error).sum::<f64>() / 3.0;
    }
    println!(
        "{{{about},\"spp\":{},\"replicates\":{count},\"width\":{},\"reuse\":{},\"image_printed\":{:.4},\
         \"printed_over_true_variance\":{:.3}}}",
        arguments.spp,
        arguments.width,
        scene.integrator.reuse(),
        held as f64 / count / 3.0,
        variances[0] / variances[1]
    );
    Ok(())
}

/// An estimator of a pixel's confidence interval.
struct Estimator {
    /// Number of blocks from whose means the variance is estimated.
    blocks: usize,
    /// Whether the quantile is Student's instead of the normal one.
    student: bool,
    /// Whether a variance is at least the mean of its neighbours', as in `validate intervals`.
    smoothed: bool,
}

fn judge(about: &str, scene: &Scene, arguments: &Arguments) -> Result<(), String> {
    let all: Result<Vec<_>, String> =
        (0..arguments.replicates).map(|seed| replicate(scene, seed, arguments.spp)).collect();
    let all = all?;
    let (count, width) = (all[0].len(), arguments.width as usize);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let truths: Vec<f64> =
        (0..count).map(|p| all.iter().map(|r| mean(&r[p])).sum::<f64>() / all.len() as f64).collect();
    let truth = mean(&truths);
    // Values that differ by the rounding of f32 only have no variance.
    let noisy: Vec<bool> =
        (0..count).map(|p| all.iter().any(|r| (mean(&r[p]) - truths[p]).abs() > 1e-6 * truths[p])).collect();
    for Estimator { blocks, student, smoothed } in estimators((arguments.spp / BLOCK) as usize) {
        let degrees = if student { blocks as f64 - 1.0 } else { f64::INFINITY };
        let t = student_quantile(0.05, degrees);
        let (mut held, mut images_held, mut extrapolated_held, mut variances) =
            (0u64, [0u64; 2], 0u64, [0.0; 2]);
        for replicate in &all {
            let found: Vec<(f64, f64)> = replicate.iter().map(|values| estimate(values, blocks)).collect();
            let own: Vec<f64> = found.iter().map(|(_, v)| *v).collect();
            let widths = if smoothed {
                half_widths(width, &own, degrees, 0.95)
            } else {
                own.iter().map(|v| t * v.sqrt()).collect()
            };
            for p in (0..count).filter(|p| noisy[*p]) {
                held += u64::from((found[p].0 - truths[p]).abs() <= widths[p]);
            }
            let (m, v) = found.iter().fold((0.0, 0.0), |(m, v), pixel| (m + pixel.0, v + pixel.1));
            // As many pixels, were they all alike, would make as uncertain a variance.
            let effective_pixels = v * v / own.iter().map(|v| v * v).sum::<f64>();
            let (m, v) = (m / count as f64, v / (count * count) as f64);
            extrapolated_held +=
                u64::from((m - truth).abs() <= NORMAL_95 * extrapolated(replicate, v, blocks).sqrt());
            for (held, t) in
                images_held.iter_mut().zip([NORMAL_95, student_quantile(0.05, 2.0 * effective_pixels)])
            {
                *held += u64::from((m - truth).abs() <= t * v.sqrt());
            }
            variances = [variances[0] + v, variances[1] + (m - truth) * (m - truth)];
        }
        let pixels = noisy.iter().filter(|n| **n).count() * all.len();
        println!(
            "{{{about},\"spp\":{},\"replicates\":{},\"blocks\":{blocks},\"student\":{student},\"smoothed\":{smoothed},\
             \"pixels\":{:.4},\"image\":{:.4},\"image_student\":{:.4},\"image_extrapolated\":{:.4},\"estimated_over_true_variance\":{:.3}}}",
            arguments.spp,
            all.len(),
            held as f64 / pixels.max(1) as f64,
            images_held[0] as f64 / all.len() as f64,
            images_held[1] as f64 / all.len() as f64,
            extrapolated_held as f64 / all.len() as f64,
            variances[0] / variances[1]
        );
    }
    Ok(())
}

/// The estimator of the file format (every range is a block, normal quantile), and variants of it.
fn estimators(pieces: usize) -> Vec<Estimator> {
    let mut lengths = vec![pieces, pieces / 4, 8, 4];
    lengths.retain(|blocks| (2..=pieces).contains(blocks));
    lengths.sort_unstable();
    lengths.dedup();
    let plain = Estimator { blocks: pieces, student: false, smoothed: false };
    let others = lengths
        .into_iter()
        .rev()
        .flat_map(|blocks| [false, true].map(|smoothed| Estimator { blocks, student: true, smoothed }));
    std::iter::once(plain).chain(others).collect()
}

/// The variance of the image's mean, extrapolated from its estimate `v` with `blocks` blocks and that with a
/// quarter as many. With samples whose mean has a variance ∝ n^−θ, B blocks yield B^(θ−1) times the variance;
/// the ratio r of both estimates is 4^(1−θ), and v r^log₄B is what one block would yield. For independent
/// samples r = 1.
fn extrapolated(replicate: &[Vec<f64>], v: f64, blocks: usize) -> f64 {
    if blocks < 8 {
        return v;
    }
    let coarse: f64 = replicate.iter().map(|values| estimate(values, blocks / 4).1).sum();
    let ratio = coarse / (replicate.len() * replicate.len()) as f64 / v;
    v * libm::pow(ratio, libm::log2(blocks as f64) / 2.0)
}

/// Mean of the values, and the variance of that mean from the differences between blocks.
fn estimate(values: &[f64], blocks: usize) -> (f64, f64) {
    let length = values.len() / blocks;
    let means: Vec<f64> =
        values.chunks_exact(length).map(|c| c.iter().sum::<f64>() / length as f64).collect();
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    (mean, means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / (n * (n - 1.0)))
}

const NORMAL_95: f64 = 1.959_963_984_540_054;
