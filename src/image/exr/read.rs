//! Reading of OpenEXR files.

use super::hash::hash;
use super::{HASH, PREFIX, SHARD_PART, VARIANCE, claim, word_name};
use crate::film::Window;
use crate::film::{Accumulators, BLOCK, ChannelAccumulator};
use crate::image::provenance::{Attribute, Provenance};
use crate::image::{COLOURS, Channel, Image, ImageError};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, FlatSamples, IntegerBounds, Layer, LayerAttributes, Layers,
    ReadChannels, ReadLayers, Vec2, read,
};
use std::collections::BTreeMap;
use std::path::Path;

type File = exr::prelude::Image<Layers<AnyChannels<FlatSamples>>>;

/// Reads an image from a flat OpenEXR file, its own or another program's. Of the latter's parts the first is
/// taken, with half floats and integers converted to floats.
pub fn read_exr(path: &Path) -> Result<Image, ImageError> {
    claim::check(path).map_err(|error| ImageError::new(error).at(path))?;
    let reader =
        read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let file = reader.from_file(path).map_err(|error| ImageError::new(error).at(path))?;
    decode(file).map_err(|error| error.at(path))
}

/// An image without its values, as [`Image`] has them in memory: every channel is empty, and so are the
/// accumulators.
pub(in crate::image) fn read_head(path: &Path) -> Result<Image, ImageError> {
    claim::check(path).map_err(|error| ImageError::new(error).at(path))?;
    let file = std::fs::File::open(path).map_err(|error| ImageError::new(error).at(path))?;
    let reader = exr::block::read(std::io::BufReader::new(file), false);
    let headers = reader.map(|reader| reader.headers().to_vec());
    headers.map_err(ImageError::new).and_then(|headers| head(&headers)).map_err(|error| error.at(path))
}

fn head(headers: &[Header]) -> Result<Image, ImageError> {
    let is_shard =
        |header: &&Header| header.own_attributes.layer_name.as_ref().is_some_and(|name| name.eq(SHARD_PART));
    let picture = headers.iter().find(|header| !is_shard(header));
    let picture = picture.ok_or_else(|| ImageError::new("the file has no picture"))?;
    let film = picture.shared_attributes.display_window;
    let names: Vec<String> = picture.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    let has = |name: &str| names.iter().any(|other| other == name);
    let is_variance = |name: &str| name.strip_prefix(VARIANCE).is_some_and(has);
    let mut channels = Vec::new();
    for name in names.iter().filter(|name| !is_variance(name)) {
        let variance = has(&format!("{VARIANCE}{name}")).then(Vec::new);
        channels.push(Channel { name: name.clone(), mean: vec![], variance });
    }
    sort(&mut channels);
    let provenance = provenance(&picture.own_attributes)?;
    let shard = headers.iter().any(|header| is_shard(&header)) && provenance.is_some();
    Ok(Image {
        full: (film.size.width() as u32, film.size.height() as u32),
        crop: window(film, &picture.own_attributes, picture.layer_size)?,
        accumulators: shard.then(|| Accumulators::new(0, 0, channels.len())),
        channels,
        provenance,
    })
}

fn decode(mut file: File) -> Result<Image, ImageError> {
    let film = file.attributes.display_window;
    let is_shard =
        |layer: &Part| layer.attributes.layer_name.as_ref().is_some_and(|name| name.eq(SHARD_PART));
    let shard = file.layer_data.iter().position(is_shard).map(|index| file.layer_data.remove(index));
    if file.layer_data.is_empty() {
        return Err(ImageError::new("the file has no picture"));
    }
    let layer = file.layer_data.remove(0);
    let crop = window(film, &layer.attributes, layer.size)?;
    let provenance = provenance(&layer.attributes)?;
    let channels = channels(layer.channel_data, crop)?;
    let accumulators = match (shard, &provenance) {
        (Some(shard), Some(provenance)) => {
            if window(film, &shard.attributes, shard.size)? != crop
                || !provenance.samples.start.is_multiple_of(BLOCK)
            {
                return Err(ImageError::new("the accumulators do not fit the picture"));
            }
            Some(accumulators(shard.channel_data, crop, &channels)?)
        }
        _ => None,
    };
    let written =
        layer.attributes.other.iter().find(|(name, _)| name.to_string() == format!("{PREFIX}{HASH}"));
    if let Some((_, AttributeValue::Text(written))) = written
        && written.to_string() != hash(&channels, accumulators.as_ref())
    {
        return Err(ImageError::new("the file is damaged: its values are not those that were written"));
    }
    let full = (film.size.width() as u32, film.size.height() as u32);
    Ok(Image { full, crop, channels, provenance, accumulators })
}

type Part = Layer<AnyChannels<FlatSamples>>;

/// The data window relative to the upper left corner of the display window.
fn window(
    film: IntegerBounds,
    attributes: &LayerAttributes,
    size: Vec2<usize>,
) -> Result<Window, ImageError> {
    let data = IntegerBounds::new(attributes.layer_position, size);
    if !film.contains(data) {
        return Err(ImageError::new("the data window reaches beyond the display window"));
    }
    let Vec2(x, y) = data.position - film.position;
    Ok(Window {
        x: x as u32,
        y: y as u32,
        width: data.size.width() as u32,
        height: data.size.height() as u32,
    })
}

/// The provenance, if the file has any of its attributes.
fn provenance(attributes: &LayerAttributes) -> Result<Option<Provenance>, ImageError> {
    let mut found = BTreeMap::new();
    for (name, value) in &attributes.other {
        let value = match value {
            AttributeValue::Text(value) => Attribute::Text(value.to_string()),
            AttributeValue::I32(value) => Attribute::Integer(*value),
            AttributeValue::F32(value) => Attribute::Real(*value),
            _ => continue,
        };
        if let Some(name) = name.to_string().strip_prefix(PREFIX).filter(|name| *name != HASH) {
            found.insert(name.to_owned(), value);
        }
    }
    if found.is_empty() { Ok(None) } else { Provenance::from_attributes(found).map(Some) }
}

/// The channels with their variances; `R G B` first, the others by name.
fn channels(channels: AnyChannels<FlatSamples>, crop: Window) -> Result<Vec<Channel>, ImageError> {
    let mut found = BTreeMap::new();
    for AnyChannel { name, sample_data, .. } in channels.list {
        if sample_data.len() != crop.pixels() {
            return Err(ImageError::new(format!("the channel `{name}` is subsampled")));
        }
        let values = match sample_data {
            FlatSamples::F32(values) => values,
            other => other.values_as_f32().collect(),
        };
        found.insert(name.to_string(), values);
    }
    let names: Vec<String> = found.keys().cloned().collect();
    let mut channels = Vec::new();
    for name in names {
        // A variance has been taken together with its channel, which comes before it or after it.
        let is_variance = name.strip_prefix(VARIANCE).is_some_and(|of| found.contains_key(of));
        if !is_variance && let Some(mean) = found.remove(&name) {
            let variance = found.remove(&format!("{VARIANCE}{name}"));
            channels.push(Channel { name, mean, variance });
        }
    }
    sort(&mut channels);
    Ok(channels)
}

/// `R G B` first, the others in the order they have.
fn sort(channels: &mut [Channel]) {
    channels.sort_by_key(|channel| COLOURS.iter().position(|name| *name == channel.name).unwrap_or(3));
}

fn accumulators(
    words: AnyChannels<FlatSamples>,
    crop: Window,
    channels: &[Channel],
) -> Result<Accumulators, ImageError> {
    let mut found: BTreeMap<String, Vec<u32>> = BTreeMap::new();
    for AnyChannel { name, sample_data, .. } in words.list {
        if let FlatSamples::U32(values) = sample_data
            && values.len() == crop.pixels()
        {
            found.insert(name.to_string(), values);
        }
    }
    let mut accumulators = Accumulators::new(crop.width, crop.height, channels.len());
    for (index, Channel { name, .. }) in channels.iter().enumerate() {
        let mut planes = Vec::new();
        for word in (0..Accumulators::WORDS).map(|word| word_name(name, word)) {
            let missing = || ImageError::new(format!("the channel `{word}` of the accumulators is missing"));
            planes.push(found.remove(&word).ok_or_else(missing)?);
        }
        let positions = (0..crop.height).flat_map(|y| (0..crop.width).map(move |x| (x, y)));
        for (pixel, (x, y)) in positions.enumerate() {
            let words = std::array::from_fn(|word| planes[word][pixel]);
            let damaged =
                || ImageError::new(format!("the accumulator `{name}` of pixel ({x}, {y}) is damaged"));
            accumulators.pixel_mut(x, y)[index] =
                ChannelAccumulator::from_words(&words).ok_or_else(damaged)?;
        }
    }
    Ok(accumulators)
}
