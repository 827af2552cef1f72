//! The colours of an OpenEXR image that a scene refers to, as linear sRGB.
//!
//! A file says what its channels are by their names (R G B, X Y Z, luminance and chroma, Y alone) and by the
//! attribute `chromaticities`: the places of its primaries and of its white on the CIE diagram (*Technical
//! Introduction to OpenEXR*, "RGB Color" and "Luminance/Chroma Images").

use crate::image::Pixels;
use crate::math::DVec3;
use crate::spectrum::observer::{RGB_TO_XYZ, xyz_to_rgb};
use exr::meta::attribute::Chromaticities;
use exr::prelude::*;
use glam::DMat3;
use std::path::Path;

/// The colour space of a pixel's three numbers.
enum Space {
    /// Linear sRGB, which has the primaries of Rec. 709.
    Srgb,
    Xyz,
    /// Other primaries: the columns are their X, Y, Z.
    Primaries(DMat3),
}

impl Space {
    fn of(chromaticities: Option<Chromaticities>) -> std::result::Result<Self, String> {
        let Some(Chromaticities { red, green, blue, white }) = chromaticities else { return Ok(Self::Srgb) };
        let places = [red, green, blue, white].map(|place| [f64::from(place.0), f64::from(place.1)]);
        let is = |others: [[f64; 2]; 4]| {
            let apart =
                places.as_flattened().iter().zip(others.as_flattened()).map(|(a, b)| (a - b) * (a - b));
            // As near as Mitsuba takes them for the same; files have them to four digits.
            apart.sum::<f64>() < 1e-6
        };
        const THIRD: f64 = 1.0 / 3.0;
        if is([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]) {
            return Ok(Self::Srgb);
        }
        if is([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [THIRD, THIRD]]) {
            return Ok(Self::Xyz);
        }
        // Each primary as bright as makes the sum white of luminance 1.
        let [red, green, blue, white] = places.map(|[x, y]| DVec3::new(x, y, 1.0 - x - y));
        let unscaled = DMat3::from_cols(red, green, blue);
        let amounts = unscaled.inverse() * (white / white.y);
        let matrix = unscaled * DMat3::from_diagonal(amounts);
        match matrix.is_finite() {
            true => Ok(Self::Primaries(matrix)),
            false => Err("its `chromaticities` are no primaries".into()),
        }
    }

    fn to_srgb(&self, values: [f32; 3]) -> [f32; 3] {
        let wide = values.map(f64::from);
        match self {
            Self::Srgb => values,
            Self::Xyz => xyz_to_rgb(wide).map(|v| v as f32),
            Self::Primaries(matrix) => {
                xyz_to_rgb((*matrix * DVec3::from_array(wide)).to_array()).map(|v| v as f32)
            }
        }
    }

    /// The contributions of the three numbers to the luminance.
    fn luminance(&self) -> [f64; 3] {
        match self {
            Self::Srgb => RGB_TO_XYZ[1],
            Self::Xyz => [0.0, 1.0, 0.0],
            Self::Primaries(matrix) => matrix.row(1).to_array(),
        }
    }
}

/// Reads the first part of a file: three channels of colours, or one of luminance. Alpha is dropped.
pub fn pixels(path: &Path) -> std::result::Result<Pixels, String> {
    super::claim::check(path)?;
    let image = read_first_flat_layer_from_file(path).map_err(|e| e.to_string())?;
    let (width, height) = (image.layer_data.size.width(), image.layer_data.size.height());
    let channel = |names: [&str; 2]| {
        let mut list = image.layer_data.channel_data.list.iter();
        let found = list.find(|c| names.contains(&c.name.to_string().as_str()))?;
        Some(found.sample_data.values_as_f32().collect::<Vec<f32>>())
    };
    let three = |names: [[&str; 2]; 3]| {
        let [a, b, c] = names.map(channel);
        Some([a?, b?, c?])
    };
    let space = Space::of(image.attributes.chromaticities)?;
    if let Some(rgb) = three([["R", "r"], ["G", "g"], ["B", "b"]]) {
        return coloured((width, height), rgb, |values| space.to_srgb(values));
    }
    if let Some(xyz) = three([["X", "x"], ["Y", "y"], ["Z", "z"]]) {
        return coloured((width, height), xyz, |values| Space::Xyz.to_srgb(values));
    }
    if let Some(chroma) = three([["Y", "y"], ["RY", "ry"], ["BY", "by"]]) {
        let [of_red, of_green, of_blue] = space.luminance();
        return coloured((width, height), chroma, |[luminance, ry, by]| {
            let (r, b) = ((ry + 1.0) * luminance, (by + 1.0) * luminance);
            let g = (f64::from(luminance) - f64::from(r) * of_red - f64::from(b) * of_blue) / of_green;
            space.to_srgb([r, g as f32, b])
        });
    }
    match channel(["Y", "y"]).or_else(|| channel(["L", "l"])) {
        Some(values) => Ok(Pixels { width, height, channels: 1, values, encoded: false }),
        None => Err("the EXR has neither the channels R, G, B nor X, Y, Z nor Y".into()),
    }
}

fn coloured(
    (width, height): (usize, usize),
    channels: [Vec<f32>; 3],
    to_srgb: impl Fn([f32; 3]) -> [f32; 3],
) -> std::result::Result<Pixels, String> {
    if channels.iter().any(|channel| channel.len() != width * height) {
        return Err("its channels have fewer samples than there are pixels".to_owned());
    }
    let values = (0..width * height).flat_map(|i| to_srgb(channels.each_ref().map(|channel| channel[i])));
    Ok(Pixels { width, height, channels: 3, values: values.collect(), encoded: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of one pixel.
    fn read(channels: &[(&str, f32)], chromaticities: Option<[[f32; 2]; 4]>) -> Pixels {
        let list =
            channels.iter().map(|(name, value)| AnyChannel::new(*name, FlatSamples::F32(vec![*value])));
        let mut image = Image::from_channels((1, 1), AnyChannels::sort(list.collect()));
        image.attributes.chromaticities = chromaticities.map(|places| {
            let [red, green, blue, white] = places.map(|[x, y]| Vec2(x, y));
            Chromaticities { red, green, blue, white }
        });
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pixel.exr");
        image.write().to_file(&path).unwrap();
        pixels(&path).unwrap()
    }

    fn assert_near(pixels: &Pixels, expected: [f32; 3]) {
        assert_eq!(pixels.channels, 3);
        let near = pixels.values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-4);
        assert!(near, "{:?} and not {expected:?}", pixels.values);
    }

    #[test]
    fn colours_are_those_of_the_primaries_that_the_file_names() {
        // What Mitsuba 3.9.1 makes of them.
        let rgb = [("R", 0.3), ("G", 0.2), ("B", 0.1)];
        assert_near(&read(&rgb, None), [0.3, 0.2, 0.1]);
        let rec_2020 = [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]];
        assert_near(&read(&rgb, Some(rec_2020)), [0.3733, 0.1884, 0.0863]);
        let third = 1.0 / 3.0;
        let xyz = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [third, third]];
        assert_near(&read(&rgb, Some(xyz)), [0.6149, 0.0886, 0.0816]);
        assert_near(&read(&[("X", 0.3), ("Y", 0.2), ("Z", 0.1)], None), [0.6149, 0.0886, 0.0816]);
    }

    #[test]
    fn chroma_is_relative_to_luminance() {
        // R = 0.3, B = 0.1 of a luminance of 0.2 = 0.2126·0.3 + 0.7152 G + 0.0722·0.1.
        assert_near(&read(&[("Y", 0.2), ("RY", 0.5), ("BY", -0.5)], None), [0.3, 0.180_37, 0.1]);
    }

    #[test]
    fn luminance_alone_is_grey() {
        let grey = read(&[("Y", 0.25), ("A", 1.0)], None);
        assert_eq!((grey.channels, grey.values), (1, vec![0.25]));
    }
}
