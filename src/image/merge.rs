//! Joining images that were rendered in parts: by windows, by sample ranges, or both.
//!
//! A part is a box in (column, row, sample). Parts merge if their boxes are disjoint and fill the box around
//! them all; how they divide it is free. Every pixel of the result is the exact sum of what the parts hold of
//! it, so the result does not depend on the division or on the order, and equals that of one run bit for bit.

use super::coverage::{Part, check_coverage};
use super::exr::{read_exr, read_head};
use super::{Channel, Image, ImageError, Provenance, Window};
use crate::film::{Accumulators, BLOCK};
use std::path::{Path, PathBuf};

/// Merges files into one image, a shard if they are shards. Whether they fit is known from their heads; then
/// they are read one after the other, so that only one of them is in memory beside the result.
///
/// # Errors
/// As [`merge`] has them; and if a file cannot be read, or changes meanwhile.
pub fn merge_files(paths: Vec<PathBuf>) -> Result<Image, ImageError> {
    let heads = paths.into_iter().map(|path| read_head(&path).map(|head| (path, head)));
    let heads = heads.collect::<Result<Vec<_>, _>>()?;
    let load = |(path, head): (PathBuf, Image)| {
        let image = read_exr(&path)?;
        let same = image.crop == head.crop
            && image.provenance == head.provenance
            && image.accumulators.is_some() == head.accumulators.is_some();
        if same { Ok(image) } else { Err(ImageError::new("the file has changed").at(&path)) }
    };
    merge_parts(heads, load)
}

/// Merges images into one, a shard if they are shards. The paths name the images in error messages.
///
/// # Errors
/// If there is no image; if two of them differ in scene, seed, version, kernel, integrator, film or channels,
/// or overlap; if a pixel or a range of samples is missing; or if images that are not shards hold different
/// samples.
pub fn merge(images: Vec<(PathBuf, Image)>) -> Result<Image, ImageError> {
    merge_parts(images, |(_, image)| Ok(image))
}

/// Merges the images that `load` makes of heads, one after the other. The values of heads are not used.
fn merge_parts(
    heads: Vec<(PathBuf, Image)>,
    mut load: impl FnMut((PathBuf, Image)) -> Result<Image, ImageError>,
) -> Result<Image, ImageError> {
    let Some((first_path, first)) = heads.first() else {
        return Err(ImageError::new("there is nothing to merge"));
    };
    let mut rendered = said(first_path, first)?.clone();
    let mut parts = Vec::new();
    for (path, image) in &heads {
        let provenance = said(path, image)?;
        if let Some(reason) = incompatibility((first, &rendered), (image, provenance))? {
            return Err(refusal(first_path, path, &reason));
        }
        if image.accumulators.is_some() && !provenance.samples.start.is_multiple_of(BLOCK) {
            let start = provenance.samples.start;
            return Err(
                ImageError::new(format!("begins at sample {start}, not at a multiple of {BLOCK}")).at(path)
            );
        }
        parts.push(Part { path, window: image.crop, samples: provenance.samples.clone() });
    }
    let (window, samples) = check_coverage(&parts)?;
    rendered.samples = samples;
    let shard = first.accumulators.is_some();
    let full = first.full;
    let mut result = Image {
        full,
        crop: window,
        channels: first.channels.iter().map(|channel| blank(channel, window)).collect(),
        provenance: Some(rendered.clone()),
        accumulators: shard.then(|| Accumulators::new(window.width, window.height, first.channels.len())),
    };
    // Each part is released as soon as it has been added.
    for head in heads {
        place(&mut result, &load(head)?);
    }
    let Some(accumulators) = result.accumulators.take() else {
        return Ok(result);
    };
    let names: Vec<String> = result.channels.iter().map(|channel| channel.name.clone()).collect();
    let mut developed = Image::from_accumulators(full, window, &names, rendered, accumulators, true);
    for (channel, blank) in developed.channels.iter_mut().zip(&result.channels) {
        if blank.variance.is_none() {
            channel.variance = None;
        }
    }
    Ok(developed)
}

/// What an image says that it is of.
fn said<'a>(path: &Path, image: &'a Image) -> Result<&'a Provenance, ImageError> {
    image
        .provenance
        .as_ref()
        .ok_or_else(|| ImageError::new("the file does not say what was rendered").at(path))
}

/// Why two images cannot be merged, wherever they lie.
fn incompatibility(
    (a, a_provenance): (&Image, &Provenance),
    (b, b_provenance): (&Image, &Provenance),
) -> Result<Option<String>, ImageError> {
    if let Some((name, ours, theirs)) = a_provenance.difference(b_provenance)? {
        return Ok(Some(format!("their {name} differs, {ours} and {theirs}")));
    }
    if a.full != b.full {
        return Ok(Some(format!(
            "their films differ, {} × {} and {} × {}",
            a.full.0, a.full.1, b.full.0, b.full.1
        )));
    }
    let names = |image: &Image| {
        let mut names: Vec<_> =
            image.channels.iter().map(|channel| (channel.name.clone(), channel.variance.is_some())).collect();
        names.sort_unstable();
        names
    };
    if names(a) != names(b) {
        return Ok(Some("their channels differ".into()));
    }
    if a.accumulators.is_some() != b.accumulators.is_some() {
        return Ok(Some("one of them was rendered with --samples and the other was not".into()));
    }
    if a.accumulators.is_none() && a_provenance.samples != b_provenance.samples {
        let ranges = (&a_provenance.samples, &b_provenance.samples);
        return Ok(Some(format!(
            "they hold different samples, {:?} and {:?}, but are not shards",
            ranges.0, ranges.1
        )));
    }
    Ok(None)
}

pub(super) fn refusal(a: &Path, b: &Path, reason: &str) -> ImageError {
    ImageError::new(format!("{} and {} cannot be merged: {reason}", a.display(), b.display()))
}

/// A channel of zeros.
fn blank(channel: &Channel, window: Window) -> Channel {
    let zeros = vec![0.0; window.pixels()];
    Channel {
        name: channel.name.clone(),
        variance: channel.variance.as_ref().map(|_| zeros.clone()),
        mean: zeros,
    }
}

/// Puts a part where it belongs: its accumulators are added, or, where it has none, its values copied.
fn place(result: &mut Image, part: &Image) {
    let (left, top) = (part.crop.x - result.crop.x, part.crop.y - result.crop.y);
    let stride = result.crop.width as usize;
    for (target, channel) in result.channels.iter_mut().enumerate() {
        let Some(source) = part.channels.iter().position(|candidate| candidate.name == channel.name) else {
            continue;
        };
        if let (Some(sums), Some(addends)) = (&mut result.accumulators, &part.accumulators) {
            for y in 0..part.crop.height {
                for x in 0..part.crop.width {
                    sums.pixel_mut(left + x, top + y)[target].merge(&addends.pixel(x, y)[source]);
                }
            }
        } else {
            let origin = top as usize * stride + left as usize;
            let from = &part.channels[source];
            copy_rows(&mut channel.mean, origin, stride, &from.mean, part.crop.width);
            if let (Some(to), Some(from)) = (&mut channel.variance, &from.variance) {
                copy_rows(to, origin, stride, from, part.crop.width);
            }
        }
    }
}

fn copy_rows(to: &mut [f32], origin: usize, stride: usize, from: &[f32], width: u32) {
    for (row, values) in from.chunks_exact(width as usize).enumerate() {
        let start = origin + row * stride;
        to[start..start + values.len()].copy_from_slice(values);
    }
}

#[cfg(test)]
mod tests;
