//! The command line of `validate images`.

use super::calibration::{EFFORT, Row, calibrate};
use crate::console::{check_writable, percentage, say, write};
use crate::references::ROUNDING;
use etalon::files::write_file;
use std::error::Error;
use std::path::{Path, PathBuf};
use validation::Verdict;
use validation::image::{self, ChannelComparison, Errors, PixelFigures, Settings};
use validation::report::to_json;

/// Whether two images have the same expectation.
#[derive(clap::Args)]
pub struct Arguments {
    /// The reference
    #[arg(required_unless_present = "calibrate")]
    a: Option<PathBuf>,
    #[arg(required_unless_present = "calibrate")]
    b: Option<PathBuf>,
    /// Instead, ask the comparison itself: false alarms and power on renders of the reference scenes
    #[arg(long, conflicts_with_all = ["a", "b", "map", "tile_map", "margin", "rounding"])]
    calibrate: bool,
    /// Largest relative difference of a channel's mean that is none, such as 0.25%
    #[arg(long, default_value = "0.25%", value_parser = percentage)]
    margin: f64,
    /// Largest relative difference of values without noise that is none; unless given, what renderers that
    /// add up in `f32` leave, 0.0008%
    #[arg(long, value_parser = percentage)]
    rounding: Option<f64>,
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a picture of signed z-scores, pixel by pixel
    #[arg(long, value_name = "PNG")]
    map: Option<PathBuf>,
    /// The same of tiles of 16 × 16 pixels, which see differences that pixels hide in their noise
    #[arg(long, value_name = "PNG")]
    tile_map: Option<PathBuf>,
}

/// Compares two images, or calibrates the comparison.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn Error>> {
    let Arguments { a, b, calibrate, margin, rounding, json, map, tile_map } = arguments;
    let read: Vec<&Path> = [&a, &b].into_iter().flatten().map(PathBuf::as_path).collect();
    check_writable(&read, &[&json, &map, &tile_map])?;
    match (a, b) {
        (Some(a), Some(b)) if !calibrate => {
            let rounding = rounding.unwrap_or(ROUNDING);
            let settings = Settings { rounding, ..Settings::with_margin(margin) };
            let (first, second) = (image::load_whole(&a)?, image::load_whole(&b)?);
            if first.begins != second.begins {
                return Err(format!(
                    "the images show different parts of the film: one begins at pixel {:?}, the other at {:?}",
                    first.begins, second.begins
                )
                .into());
            }
            let comparison = image::compare(&first.image, &second.image, &settings)?;
            if let Some(path) = map {
                write_file(&path, &image::difference_map(&first.image, &second.image, &settings)?)?;
            }
            if let Some(path) = tile_map {
                write_file(&path, &image::tile_map(&first.image, &second.image, &settings)?)?;
            }
            write(json.as_deref(), || Ok(to_json(&comparison)?))?;
            say(format_args!("{}: {}", comparison.verdict, comparison.message));
            if !comparison.faults.unknown_variance.is_empty() {
                for (path, file) in [(&a, &first), (&b, &second)] {
                    file.unknown.iter().for_each(|why| say(format_args!("  {}: {why}", path.display())));
                }
            }
            comparison.channels.iter().for_each(tell_errors);
            comparison.channels.iter().for_each(tell_shared_noise);
            Ok(comparison.verdict)
        }
        _ => calibration(json),
    }
}

fn tell_errors(channel: &ChannelComparison) {
    let Errors { bias, mse, expected_mse, relative_mse, relative_mse_trimmed, mape, ssim } = &channel.errors;
    say(format_args!(
        "  {}: bias {bias:+.3e}, MSE {mse:.3e} (noise alone {expected_mse:.3e}), relMSE {relative_mse:.3e} (trimmed {relative_mse_trimmed:.3e}), MAPE {:.2} %, SSIM {ssim:.4}",
        channel.name,
        100.0 * mape
    ));
}

/// Says so where variances of pixels do not tell how noisy sums are.
fn tell_shared_noise(channel: &ChannelComparison) {
    let PixelFigures { neighbour_correlation, shared_noise, .. } = channel.pixels;
    if shared_noise > 1.0 {
        say(format_args!(
            "  {}: neighbouring pixels share noise (correlation {neighbour_correlation:.2}): variances of means are \
             taken for {shared_noise:.1} times the sum of those of pixels",
            channel.name
        ));
    }
}

fn calibration(json: Option<PathBuf>) -> Result<Verdict, Box<dyn Error>> {
    let found = calibrate(&EFFORT, |row: &Row| {
        let Row { scene, rejected, pairs, power, .. } = row;
        say(format_args!("{scene}: {rejected} of {pairs} honest pairs rejected, power {power:.2}"));
    })?;
    say(format_args!("{}: {}", found.verdict, found.message));
    write(json.as_deref(), || Ok(to_json(&found)?))?;
    Ok(found.verdict)
}
