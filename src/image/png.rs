//! Pictures for the eye: 8-bit sRGB, and PNG files of them.

use super::srgb::encode_srgb;
use super::{COLOURS, Image, ImageError};
use crate::files::write_file;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use std::path::Path;

/// The colour of values that are not finite; no renderer makes it by accident.
const MAGENTA: [u8; 3] = [255, 0, 255];

/// A picture of 8-bit sRGB values, pixel by pixel in rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb8 {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// The pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl Rgb8 {
    /// A picture of one colour.
    pub fn filled(width: u32, height: u32, color: [u8; 3]) -> Rgb8 {
        Rgb8 { width, height, pixels: vec![color; width as usize * height as usize] }
    }

    /// Copies another picture into this one, its upper left pixel to (`left`, `top`). What does not fit is
    /// cut off.
    pub fn paste(&mut self, picture: &Rgb8, left: u32, top: u32) {
        for y in 0..picture.height.min(self.height.saturating_sub(top)) {
            for x in 0..picture.width.min(self.width.saturating_sub(left)) {
                let target = (top + y) as usize * self.width as usize + (left + x) as usize;
                self.pixels[target] = picture.pixels[y as usize * picture.width as usize + x as usize];
            }
        }
    }
}

/// Finds out whether a picture can be made of an image with channels of these names.
///
/// # Errors
/// With the name of one that is missing.
pub fn check_developable(names: &[String]) -> Result<(), ImageError> {
    match COLOURS.iter().find(|shown| !names.iter().any(|name| name == *shown)) {
        None => Ok(()),
        Some(missing) => Err(ImageError::new(format!(
            "no picture can be made: the image has no channel `{missing}`, and R, G and B are expected"
        ))),
    }
}

/// The picture of an image's channels `R G B`. Pixels that are not finite are magenta.
///
/// # Errors
/// If the image lacks one of the channels.
pub fn develop(image: &Image) -> Result<Rgb8, ImageError> {
    let plane = |name: &str| {
        let channel = image.channel(name).filter(|channel| channel.mean.len() == image.crop.pixels());
        channel.ok_or_else(|| ImageError::new(format!("the image has no channel `{name}`")))
    };
    let [r, g, b] = COLOURS;
    let (red, green, blue) = (plane(r)?, plane(g)?, plane(b)?);
    let pixel = |i: usize| {
        let linear = [red.mean[i], green.mean[i], blue.mean[i]];
        if linear.iter().all(|value| value.is_finite()) { linear.map(encode_srgb) } else { MAGENTA }
    };
    let pixels = (0..image.crop.pixels()).map(pixel).collect();
    Ok(Rgb8 { width: image.crop.width, height: image.crop.height, pixels })
}

/// Writes a picture to a PNG file, whole or not at all.
pub fn write_png(path: &Path, picture: &Rgb8) -> Result<(), ImageError> {
    Ok(write_file(path, &encode_png(picture).map_err(|error| error.at(path))?)?)
}

/// The bytes of a PNG file of a picture. Equal pictures give equal bytes.
pub fn encode_png(picture: &Rgb8) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    // Stated here, so that another default of the encoder does not change files.
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
    encoder
        .write_image(
            picture.pixels.as_flattened(),
            picture.width,
            picture.height,
            image::ExtendedColorType::Rgb8,
        )
        .map_err(ImageError::new)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Window;
    use crate::image::Channel;

    fn rgb(values: &[[f32; 3]]) -> Image {
        let channel = |(i, name): (usize, &str)| Channel {
            name: name.into(),
            mean: values.iter().map(|value| value[i]).collect(),
            variance: None,
        };
        let crop = Window { x: 0, y: 0, width: values.len() as u32, height: 1 };
        let channels = ["R", "G", "B"].into_iter().enumerate().map(channel).collect();
        Image { full: (crop.width, 1), crop, channels, provenance: None, accumulators: None }
    }

    #[test]
    fn values_that_are_not_finite_are_magenta() {
        let image = rgb(&[[0.0, 1.0, 0.5], [f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
        let picture = Rgb8 { width: 3, height: 1, pixels: vec![[0, 255, 188], MAGENTA, MAGENTA] };
        assert_eq!(develop(&image), Ok(picture));
        let mut grey = image;
        grey.channels.truncate(1);
        assert!(develop(&grey).is_err_and(|error| error.to_string().contains("`G`")));
    }

    #[test]
    fn a_picture_comes_back_from_its_file() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("a.png");
        let pixels = (0..=255u8).map(|i| [i, i ^ 0x55, 255 - i]).collect();
        let picture = Rgb8 { width: 32, height: 8, pixels };
        write_png(&path, &picture)?;
        let back = image::open(&path)?.into_rgb8();
        assert_eq!(back.dimensions(), (32, 8));
        assert_eq!(back.into_raw(), picture.pixels.as_flattened());
        Ok(())
    }

    #[test]
    fn pasting_cuts_off_what_does_not_fit() {
        let mut sheet = Rgb8::filled(2, 2, [0; 3]);
        sheet.paste(&Rgb8::filled(2, 2, [9; 3]), 1, 1);
        sheet.paste(&Rgb8::filled(2, 2, [7; 3]), 5, 0);
        assert_eq!(sheet.pixels, [[0; 3], [0; 3], [0; 3], [9; 3]]);
    }
}
