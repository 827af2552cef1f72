//! Writing of OpenEXR files.

use super::hash::hash;
use super::samples::Samples;
use super::{HASH, PREFIX, SHARD_PART, VARIANCE, word_name};
use crate::files::write_file;
use crate::film::Accumulators;
use crate::film::Window;
use crate::image::attributes::sort_attributes;
use crate::image::provenance::Attribute;
use crate::image::{Channel, Image, ImageError};
use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, ImageAttributes, IntegerBounds,
    Layer, LayerAttributes, Layers, LineOrder, SmallVec, Text, Vec2, WritableImage,
};
use std::io::Cursor;
use std::path::Path;

/// The red, green and blue primaries and the white point of sRGB (IEC 61966-2-1, Table 1), in CIE xy.
const SRGB: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Writes an image to a file, whole or not at all. Equal images give equal bytes.
pub fn write_exr(path: &Path, image: &Image) -> Result<(), ImageError> {
    let bytes = encode(image).map_err(|error| error.at(path))?;
    Ok(write_file(path, &bytes)?)
}

/// The bytes of the file.
pub(in crate::image) fn encode(image: &Image) -> Result<Vec<u8>, ImageError> {
    let mut attributes = LayerAttributes::default();
    if let Some(provenance) = &image.provenance {
        for (name, value) in provenance.to_attributes()? {
            let value = match value {
                Attribute::Text(value) => AttributeValue::Text(text(&value)?),
                Attribute::Integer(value) => AttributeValue::I32(value),
                Attribute::Real(value) => AttributeValue::F32(value),
            };
            attributes.other.insert(text(&format!("{PREFIX}{name}"))?, value);
        }
        let hash = AttributeValue::Text(text(&hash(&image.channels, image.accumulators.as_ref()))?);
        attributes.other.insert(text(&format!("{PREFIX}{HASH}"))?, hash);
    }
    let mut pictures = Vec::new();
    for channel in &image.channels {
        pictures.push((channel.name.clone(), Samples::Values(&channel.mean)));
        if let Some(variance) = &channel.variance {
            pictures.push((format!("{VARIANCE}{}", channel.name), Samples::Values(variance)));
        }
    }
    if pictures.iter().any(|(_, samples)| samples.len() != image.crop.pixels()) || pictures.is_empty() {
        return Err(ImageError::new("the channels do not have one value for each pixel of the window"));
    }
    let mut layers = Layers::new();
    if let Some(accumulators) = &image.accumulators {
        let words = image.channels.iter().enumerate().flat_map(|(channel, Channel { name, .. })| {
            let word = move |word| (word_name(name, word), Samples::Word { accumulators, channel, word });
            (0..Accumulators::WORDS).map(word)
        });
        if accumulators.channels() != image.channels.len()
            || (accumulators.width(), accumulators.height()) != (image.crop.width, image.crop.height)
        {
            return Err(ImageError::new("the accumulators do not fit the channels and the window"));
        }
        attributes.layer_name = Some(text("image")?);
        layers.push(layer(image.crop, attributes, pictures)?);
        layers.push(layer(image.crop, LayerAttributes::named(text(SHARD_PART)?), words)?);
    } else {
        layers.push(layer(image.crop, attributes, pictures)?);
    }
    let film = IntegerBounds::from_dimensions((image.full.0 as usize, image.full.1 as usize));
    let attributes = ImageAttributes { chromaticities: Some(SRGB), ..ImageAttributes::new(film) };
    let mut bytes = Vec::new();
    let file = exr::prelude::Image::from_layers(attributes, layers);
    file.write().to_buffered(Cursor::new(&mut bytes)).map_err(ImageError::new)?;
    sort_attributes(&mut bytes).ok_or_else(|| ImageError::new("the header is malformed"))?;
    Ok(bytes)
}

/// One part of the file. Chunks in increasing order: otherwise they come in the order in which threads
/// finish.
fn layer<'a>(
    window: Window,
    attributes: LayerAttributes,
    channels: impl IntoIterator<Item = (String, Samples<'a>)>,
) -> Result<Layer<AnyChannels<Samples<'a>>>, ImageError> {
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let corner = |value: u32| i32::try_from(value).map_err(ImageError::new);
    let attributes = attributes.with_position(Vec2(corner(window.x)?, corner(window.y)?));
    let mut list = SmallVec::new();
    for (name, samples) in channels {
        list.push(AnyChannel::new(text(&name)?, samples));
    }
    let size = (window.width as usize, window.height as usize);
    Ok(Layer::new(size, attributes, encoding, AnyChannels::sort(list)))
}

/// A text in the file's character set.
fn text(text: &str) -> Result<Text, ImageError> {
    Text::new_or_none(text).ok_or_else(|| ImageError::new(format!("`{text}` has characters beyond Latin-1")))
}
