use super::{read_exr, write_exr};
use crate::film::Accumulators;
use crate::film::Window;
use crate::image::provenance::tests::example;
use crate::image::{Channel, Image};
use std::path::Path;

/// An image of 37 × 41 pixels, more than one chunk high, within a film of 64 × 48.
pub(crate) fn picture(shard: bool) -> Image {
    let crop = Window { x: 5, y: 7, width: 37, height: 41 };
    let names = ["R", "G", "B", "S0.550,000nm", "albedo.R"].map(String::from);
    let mut accumulators = Accumulators::new(crop.width, crop.height, names.len());
    for y in 0..crop.height {
        for x in 0..crop.width {
            for (c, channel) in accumulators.pixel_mut(x, y).iter_mut().enumerate() {
                (8..22).for_each(|s| channel.add(s, f64::from(x * y) + s as f64 / (1.0 + c as f64)));
            }
        }
    }
    Image::from_accumulators((64, 48), crop, &names, example(8..22), accumulators, shard)
}

fn file(folder: &tempfile::TempDir, name: &str) -> std::path::PathBuf {
    folder.path().join(name)
}

#[test]
fn an_image_comes_back() -> std::io::Result<()> {
    let folder = tempfile::tempdir()?;
    for shard in [false, true] {
        let path = file(&folder, "a.exr");
        let image = picture(shard);
        assert_eq!(write_exr(&path, &image), Ok(()));
        assert_eq!(read_exr(&path), Ok(image));
    }
    Ok(())
}

#[test]
fn values_keep_their_bits() -> std::io::Result<()> {
    let folder = tempfile::tempdir()?;
    let mean = vec![f32::MIN_POSITIVE / 3.0, -0.0, f32::MAX, f32::INFINITY, f32::NAN, 1.0 / 3.0];
    let image = Image {
        full: (3, 2),
        crop: Window { x: 0, y: 0, width: 3, height: 2 },
        channels: vec![Channel { name: "Z".into(), mean: mean.clone(), variance: None }],
        provenance: None,
        accumulators: None,
    };
    assert_eq!(write_exr(&file(&folder, "a.exr"), &image), Ok(()));
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let back = read_exr(&file(&folder, "a.exr")).map(|image| bits(&image.channels[0].mean));
    assert_eq!(back, Ok(bits(&mean)));
    Ok(())
}

#[test]
fn equal_images_are_equal_files() -> std::io::Result<()> {
    let folder = tempfile::tempdir()?;
    for shard in [false, true] {
        let first = super::write::encode(&picture(shard));
        for _ in 0..8 {
            let mut image = picture(shard);
            if !shard {
                image.channels.reverse();
            }
            assert!(super::write::encode(&image) == first);
        }
        assert_eq!(write_exr(&file(&folder, "a.exr"), &picture(shard)), Ok(()));
        assert_eq!(std::fs::read(file(&folder, "a.exr")).ok(), first.ok());
    }
    Ok(())
}

#[test]
fn damaged_files_are_errors() -> std::io::Result<()> {
    let folder = tempfile::tempdir()?;
    let path = file(&folder, "a.exr");
    let bytes = super::write::encode(&picture(true)).unwrap_or_default();
    for length in [0, 4, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..length])?;
        let error = read_exr(&path).map_err(|error| error.to_string());
        assert!(error.is_err_and(|text| text.contains("a.exr: ")), "{length}");
    }
    assert!(read_exr(Path::new("/nonexistent.exr")).is_err());
    Ok(())
}

#[test]
fn contradictory_images_are_not_written() {
    let path = Path::new("/nonexistent/a.exr");
    let mut image = picture(false);
    image.channels[1].mean.pop();
    assert!(write_exr(path, &image).is_err_and(|error| error.cause.contains("one value for each pixel")));
    let mut image = picture(true);
    image.channels.pop();
    assert!(write_exr(path, &image).is_err_and(|error| error.cause.contains("do not fit")));
    let mut image = picture(false);
    image.channels[0].name = "λ".into();
    assert!(write_exr(path, &image).is_err_and(|error| error.cause.contains("Latin-1")));
}

/// Noise does not become smaller by compression, and is stored as it is.
#[test]
fn no_bit_of_a_value_changes_unnoticed() -> std::io::Result<()> {
    let folder = tempfile::tempdir()?;
    let noise = |i: u32| f32::from_bits(0x3f00_0000 | (i.wrapping_mul(0x9e37_79b9) >> 9));
    let image = Image {
        full: (8, 4),
        crop: Window { x: 0, y: 0, width: 8, height: 4 },
        channels: vec![Channel { name: "R".into(), mean: (1..33).map(noise).collect(), variance: None }],
        provenance: Some(example(8..22)),
        accumulators: None,
    };
    let path = file(&folder, "a.exr");
    assert_eq!(write_exr(&path, &image), Ok(()));
    let bytes = std::fs::read(&path)?;
    let mut noticed = 0;
    for at in bytes.len() - 4 * 32..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x04;
        std::fs::write(&path, damaged)?;
        match read_exr(&path) {
            Ok(found) => assert_eq!(found, image, "byte {at}"),
            Err(_) => noticed += 1,
        }
    }
    assert_eq!(noticed, 4 * 32);
    Ok(())
}
