//! Difference maps: where two images differ, in standard errors.

use std::io::Cursor;

use image::{ImageFormat, Rgb, RgbImage};

use super::{Image, ImageError, Settings, pair::Pair, tiles};

/// Magnitude of the z-score from which colours are fully saturated.
const FULL: f64 = 5.0;

/// The bytes of a PNG with the signed z-score of each pixel's worst channel: red where b is brighter, blue
/// where it is darker, white where they agree, black where a value is not finite or the variance unknown.
pub fn difference_map(a: &Image, b: &Image, settings: &Settings) -> Result<Vec<u8>, ImageError> {
    let (pairs, _) = comparable(a, b)?;
    let size = settings.tile_size.max(1);
    let pairs: Vec<_> = pairs.into_iter().map(|pair| (tiles::noise_ratio_of(&pair, size), pair)).collect();
    let score = |x: usize, y: usize| {
        let pixels = pairs.iter().map(|(ratio, pair)| pair.pixel(x, y).informed(*ratio));
        let z = pixels.map(|pixel| if pixel.is_testable() { pixel.z() } else { f64::NAN });
        worst(z)
    };
    draw(a, score)
}

/// The same map of the tiles' signed z-scores.
pub fn tile_map(a: &Image, b: &Image, settings: &Settings) -> Result<Vec<u8>, ImageError> {
    let (pairs, _) = comparable(a, b)?;
    let size = settings.tile_size.max(1);
    let columns = a.width.div_ceil(size);
    let scores: Vec<Vec<f64>> = pairs.iter().map(|pair| tiles::scores(pair, size)).collect();
    let score = |x: usize, y: usize| worst(scores.iter().map(|scores| scores[y / size * columns + x / size]));
    draw(a, score)
}

/// The channels that both images have, and the names of those that only one has. Errors: different sizes, no
/// common channel.
pub(super) fn comparable<'a>(a: &'a Image, b: &'a Image) -> Result<(Vec<Pair<'a>>, Vec<String>), ImageError> {
    if (a.width, a.height) != (b.width, b.height) {
        let sizes = format!("{}×{} and {}×{}", a.width, a.height, b.width, b.height);
        return Err(ImageError(format!("the images have different sizes: {sizes}")));
    }
    let (pairs, alone) = Pair::all(a, b);
    if pairs.is_empty() || a.width * a.height == 0 {
        return Err(ImageError(format!("the images have no channel in common (found {})", alone.join(", "))));
    }
    Ok((pairs, alone))
}

/// The score of largest magnitude; NaN if any is NaN.
fn worst(scores: impl Iterator<Item = f64>) -> f64 {
    scores.fold(0.0, |worst: f64, z| if worst.is_nan() || worst.abs() > z.abs() { worst } else { z })
}

fn draw(size: &Image, score: impl Fn(usize, usize) -> f64) -> Result<Vec<u8>, ImageError> {
    let extent = |pixels: usize| u32::try_from(pixels).map_err(|error| ImageError(error.to_string()));
    let map = RgbImage::from_fn(extent(size.width)?, extent(size.height)?, |x, y| {
        Rgb(colour(score(x as usize, y as usize)))
    });
    let mut bytes = Cursor::new(vec![]);
    map.write_to(&mut bytes, ImageFormat::Png).map_err(|error| ImageError(error.to_string()))?;
    Ok(bytes.into_inner())
}

fn colour(z: f64) -> [u8; 3] {
    if z.is_nan() {
        return [0; 3];
    }
    let pale = (255.0 * (1.0 - (z.abs() / FULL).min(1.0))).round() as u8;
    if z > 0.0 { [255, pale, pale] } else { [pale, pale, 255] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::grey;

    #[test]
    fn colours_tell_sign_and_size() {
        assert_eq!(colour(0.0), [255; 3]);
        assert_eq!(colour(99.0), [255, 0, 0]);
        assert_eq!(colour(f64::NEG_INFINITY), [0, 0, 255]);
        assert_eq!(colour(f64::NAN), [0; 3]);
        assert_eq!(worst([1.0, -3.0, 2.0].into_iter()), -3.0);
        assert!(worst([1.0, f64::NAN, 9.0].into_iter()).is_nan());
    }

    #[test]
    fn maps_are_readable_pictures() {
        let a = grey(20, &[1.0; 400], 0.01);
        let mut b = a.clone();
        b.channels[0].mean[20 * 18 + 18] = 9.0;
        let [pixels, tiles] = [difference_map, tile_map].map(|map| {
            image::load_from_memory(&map(&a, &b, &Settings::default()).unwrap()).unwrap().to_rgb8()
        });
        assert_eq!((pixels.dimensions(), tiles.dimensions()), ((20, 20), (20, 20)));
        assert_eq!((pixels[(18, 18)].0, pixels[(0, 0)].0), ([255, 0, 0], [255; 3]));
        assert_eq!((tiles[(19, 17)].0, tiles[(0, 0)].0), ([255, 0, 0], [255; 3]));
    }
}
