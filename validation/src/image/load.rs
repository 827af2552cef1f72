//! Reads OpenEXR files: channels by name, variances from `variance.<channel>`.

use std::{io::Cursor, path::Path};

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};

use super::{Channel, Image, ImageError};

/// The attributes that Etalon writes to files whose pixels share paths, or whose samples count for several.
const CORRELATED: [&str; 2] = ["etalon.reuse", "etalon.spread"];

/// The parts of files of Etalon's that can be merged: the picture, and the sums that it is made of.
const PICTURE: &str = "image";
const SUMS: &str = "accumulators";

/// The prefix of the names of variance channels.
const VARIANCE: &str = "variance.";

/// An image as a file has it.
pub struct Loaded {
    pub image: Image,
    /// The first pixel of its data window: column and row of the film.
    pub begins: (i32, i32),
    /// Why not all variances are known.
    pub unknown: Option<&'static str>,
}

/// Reads the EXR file at `path`. Errors name the file.
pub fn load(path: impl AsRef<Path>) -> Result<Image, ImageError> {
    load_whole(path).map(|loaded| loaded.image)
}

/// The same with what is not in its pixels.
pub fn load_whole(path: impl AsRef<Path>) -> Result<Loaded, ImageError> {
    let path = path.as_ref();
    let fail = |reason: String| ImageError(format!("{}: {reason}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| fail(error.to_string()))?;
    if bytes.is_empty() {
        return Err(fail("the file is empty".into()));
    }
    parse(&bytes).map_err(|error| fail(error.0))
}

/// Reads an EXR file's bytes: every channel of every part, half and integer values converted to f64. Channels
/// of a named part are called `part.channel`, but for those of the picture in a file of Etalon's that can be
/// merged with others, whose sums are left out. A channel `variance.X` becomes the variance of channel `X`,
/// unless the file declares that its pixels are correlated: then variances of pixels do not suffice for a
/// comparison, and are left out.
///
/// A file that declares more samples than one of its length can hold is refused before memory is allocated
/// for them.
pub fn from_exr(bytes: &[u8]) -> Result<Image, ImageError> {
    parse(bytes).map(|loaded| loaded.image)
}

fn parse(bytes: &[u8]) -> Result<Loaded, ImageError> {
    let head = exr::block::read(Cursor::new(bytes), false).map_err(|error| ImageError(error.to_string()))?;
    let claims = |header: &exr::meta::header::Header| {
        let size = header.layer_size;
        size.width() as u128 * size.height() as u128 * header.channels.bytes_per_pixel as u128
    };
    // No compression method of the format stores a byte of samples in less than 1/4096 of a byte.
    if head.headers().iter().any(|header| claims(header) > 4096 * bytes.len() as u128) {
        return Err(ImageError(format!("a file of {} bytes cannot hold its pixels", bytes.len())));
    }
    let file = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| ImageError(error.to_string()))?;
    let named = |name: &str| {
        let of =
            |layer: &exr::prelude::Layer<_>| layer.attributes.layer_name.as_ref().is_some_and(|n| n == name);
        file.layer_data.iter().any(of)
    };
    let mergeable = named(PICTURE) && named(SUMS);
    let mut size = None;
    let mut channels = Vec::new();
    for layer in &file.layer_data {
        let layer_size = (layer.size.width(), layer.size.height());
        if *size.get_or_insert(layer_size) != layer_size {
            return Err(ImageError("its parts have different sizes".into()));
        }
        // Of a single part the name tells nothing apart.
        let named = layer.attributes.layer_name.as_ref().filter(|_| file.layer_data.len() > 1);
        let part = named.map(ToString::to_string).filter(|name| !name.is_empty());
        let part = match part.as_deref() {
            Some(SUMS) if mergeable => continue,
            Some(PICTURE) if mergeable => None,
            _ => part,
        };
        for channel in &layer.channel_data.list {
            let name = channel.name.to_string();
            let name = part.as_ref().map_or(name.clone(), |part| format!("{part}.{name}"));
            channels.push(Channel { name, mean: widen(&channel.sample_data), variance: None });
        }
    }
    let (width, height) = size.ok_or_else(|| ImageError("it has no pixels".into()))?;
    if channels.iter().any(|channel| channel.mean.len() != width * height) {
        return Err(ImageError("subsampled channels are not supported".into()));
    }
    let mut channels = pair_variances(channels);
    let correlated = |name: &exr::meta::attribute::Text| CORRELATED.iter().any(|of| name == *of);
    let shared = file.layer_data.iter().any(|layer| layer.attributes.other.keys().any(correlated));
    if shared {
        channels.iter_mut().for_each(|channel| channel.variance = None);
    }
    let known =
        |channel: &Channel| channel.variance.as_ref().is_some_and(|of| of.iter().all(|v| v.is_finite()));
    let unknown = if shared {
        Some("its pixels share paths or samples, and variances of pixels do not tell their noise")
    } else if channels.iter().all(|channel| channel.variance.is_none()) {
        Some("it has no channels `variance.X` with the variances of the means of channels `X`")
    } else if !channels.iter().all(known) {
        Some("not all its variances are known; Etalon's are from eight samples a pixel on")
    } else {
        None
    };
    let begins = file.layer_data.first().map_or((0, 0), |layer| {
        let at = layer.attributes.layer_position;
        (at.x(), at.y())
    });
    Ok(Loaded { image: Image { width, height, channels }, begins, unknown })
}

fn widen(samples: &FlatSamples) -> Vec<f64> {
    match samples {
        FlatSamples::U32(values) => values.iter().copied().map(f64::from).collect(),
        _ => samples.values_as_f32().map(f64::from).collect(),
    }
}

/// Moves each `variance.X` (or `part.variance.X`) into channel X. A variance without its channel stays a
/// channel.
fn pair_variances(channels: Vec<Channel>) -> Vec<Channel> {
    let owner = |name: &str| {
        let at = name.match_indices(VARIANCE).find(|(at, _)| *at == 0 || name[..*at].ends_with('.'))?.0;
        Some(format!("{}{}", &name[..at], &name[at + VARIANCE.len()..]))
    };
    let names: Vec<String> = channels.iter().map(|channel| channel.name.clone()).collect();
    let owned = |channel: &Channel| owner(&channel.name).is_some_and(|owner| names.contains(&owner));
    let (variances, mut means): (Vec<Channel>, Vec<Channel>) = channels.into_iter().partition(owned);
    for variance in variances {
        let name = owner(&variance.name);
        if let Some(mean) = means.iter_mut().find(|mean| Some(&mean.name) == name.as_ref()) {
            mean.variance = Some(variance.mean);
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, Image as ExrImage, Layer, LayerAttributes, Vec2, WritableImage,
        f16,
    };

    fn bytes(channels: Vec<AnyChannel<FlatSamples>>) -> Vec<u8> {
        let list = AnyChannels::sort(channels.into());
        let layer = Layer::new(Vec2(2, 1), LayerAttributes::default(), Encoding::UNCOMPRESSED, list);
        let mut buffer = Cursor::new(Vec::new());
        ExrImage::from_layer(layer).write().to_buffered(&mut buffer).unwrap();
        buffer.into_inner()
    }

    #[test]
    fn channels_find_their_variances() {
        let single = |name: &str, values: [f32; 2]| AnyChannel::new(name, FlatSamples::F32(values.to_vec()));
        let half = AnyChannel::new("G", FlatSamples::F16(vec![f16::from_f32(0.5); 2]));
        let file = bytes(vec![
            single("R", [1.0, f32::NAN]),
            half,
            single("variance.R", [0.25, f32::INFINITY]),
            single("S0.550,000nm", [3.0, 4.0]),
            single("variance.S0.550,000nm", [0.5, 0.5]),
        ]);
        let image = from_exr(&file).unwrap();
        let names: Vec<&str> = image.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["G", "R", "S0.550,000nm"]);
        assert_eq!(image.channels[0].mean, [0.5, 0.5]);
        assert_eq!(image.channels[0].variance, None);
        assert!(image.channels[1].mean[1].is_nan());
        assert_eq!(image.channels[1].variance, Some(vec![0.25, f64::INFINITY]));
        assert_eq!(image.channels[2].variance, Some(vec![0.5, 0.5]));
    }

    #[test]
    fn a_file_that_can_be_merged_is_the_picture_in_it() {
        let part = |name: &str, channel: &str| {
            let list =
                AnyChannels::sort(vec![AnyChannel::new(channel, FlatSamples::F32(vec![1.0, 2.0]))].into());
            let attributes = LayerAttributes::named(exr::meta::attribute::Text::from(name));
            Layer::new(Vec2(2, 1), attributes, Encoding::UNCOMPRESSED, list)
        };
        let names = |parts: &[(&str, &str)]| {
            let layers: Vec<_> = parts.iter().map(|(name, channel)| part(name, channel)).collect();
            let image = ExrImage::from_layers(exr::prelude::ImageAttributes::with_size(Vec2(2, 1)), layers);
            let mut buffer = Cursor::new(Vec::new());
            image.write().to_buffered(&mut buffer).unwrap();
            let image = from_exr(&buffer.into_inner()).unwrap();
            image.channels.into_iter().map(|channel| channel.name).collect::<Vec<_>>()
        };
        assert_eq!(names(&[("image", "R"), ("accumulators", "R.00")]), ["R"]);
        assert_eq!(names(&[("image", "R"), ("mask", "A")]), ["image.R", "mask.A"]);
        assert_eq!(names(&[("rgba", "R")]), ["R"]);
    }

    #[test]
    fn variances_belong_to_the_channels_that_they_name() {
        let channel = |name: &str| Channel { name: name.into(), mean: vec![1.0], variance: None };
        let names = ["R", "variance.R", "layer.R", "layer.variance.R", "coR", "covariance.R", "variance.X"];
        let found = pair_variances(names.map(channel).to_vec());
        let told = found.iter().map(|c| (c.name.as_str(), c.variance.is_some())).collect::<Vec<_>>();
        let expected =
            [("R", true), ("layer.R", true), ("coR", false), ("covariance.R", false), ("variance.X", false)];
        assert_eq!(told, expected);
    }

    #[test]
    fn why_variances_are_unknown_and_where_a_window_begins_is_told() {
        let single = |name: &str, values: [f32; 2]| AnyChannel::new(name, FlatSamples::F32(values.to_vec()));
        let loaded = |attributes: LayerAttributes, channels: Vec<AnyChannel<FlatSamples>>| {
            let layer = Layer::new(
                Vec2(2, 1),
                attributes,
                Encoding::UNCOMPRESSED,
                AnyChannels::sort(channels.into()),
            );
            let mut buffer = Cursor::new(Vec::new());
            ExrImage::from_layer(layer).write().to_buffered(&mut buffer).unwrap();
            parse(&buffer.into_inner()).unwrap()
        };
        let plain = LayerAttributes::default;
        let of = |variance: [f32; 2]| vec![single("R", [1.0, 2.0]), single("variance.R", variance)];
        let why = |loaded: Loaded| loaded.unknown.unwrap_or("known");
        assert_eq!(why(loaded(plain(), of([0.1, 0.2]))), "known");
        assert!(why(loaded(plain(), of([0.1, f32::INFINITY]))).starts_with("not all"));
        assert!(why(loaded(plain(), vec![single("R", [1.0, 2.0])])).starts_with("it has no channels"));
        let mut shared = plain();
        shared.other.insert(CORRELATED[0].into(), exr::prelude::AttributeValue::I32(16));
        assert!(why(loaded(shared, of([0.1, 0.2]))).starts_with("its pixels share"));
        let moved = LayerAttributes { layer_position: Vec2(10, -3), ..plain() };
        assert_eq!(loaded(moved, of([0.1, 0.2])).begins, (10, -3));
    }

    #[test]
    fn rubbish_is_an_error_that_names_the_file() {
        assert!(from_exr(b"not an image").is_err());
        assert!(load("no/such.exr").unwrap_err().0.starts_with("no/such.exr: "));
    }
}
