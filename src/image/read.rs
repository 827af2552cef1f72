//! Reading image files that scenes refer to.

use super::Pixels;
use image::ImageDecoder;
use std::io::Read;
use std::path::Path;

/// Decodes EXR, PNG, JPEG, Radiance HDR or BMP; alpha is dropped. The error says what is wrong.
pub fn pixels(path: &Path) -> Result<Pixels, String> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let begin = beginning(path).map_err(|e| e.to_string())?;
    let pixels = match extension.as_str() {
        _ if begin == super::exr::claim::MAGIC => super::exr::colors::pixels(path)?,
        // Many writers sign Radiance files in their own way, so their name counts as well.
        _ if begin == RADIANCE => hdr_pixels(path)?,
        "hdr" | "rgbe" => hdr_pixels(path)?,
        "exr" => return Err("it does not begin as an OpenEXR file does".into()),
        _ => other_pixels(path)?,
    };
    if pixels.width == 0 || pixels.height == 0 {
        return Err("the image is empty".into());
    }
    match pixels.values.iter().position(|v| !v.is_finite()) {
        None => Ok(pixels),
        Some(i) => {
            let texel = i / pixels.channels;
            Err(format!("the texel ({}, {}) is not finite", texel % pixels.width, texel / pixels.width))
        }
    }
}

/// What most Radiance files begin with.
const RADIANCE: [u8; 4] = *b"#?RA";

/// The first bytes of a file; zeros if it has not as many.
fn beginning(path: &Path) -> std::io::Result<[u8; 4]> {
    let mut begin = [0; 4];
    let (mut file, mut read) = (std::fs::File::open(path)?, 0);
    while read < begin.len() {
        match file.read(&mut begin[read..])? {
            0 => break,
            more => read += more,
        }
    }
    Ok(begin)
}

/// The signature is not held against a file.
fn hdr_pixels(path: &Path) -> Result<Pixels, String> {
    let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    let decoder = image::codecs::hdr::HdrDecoder::new_nonstrict(std::io::BufReader::new(file));
    let decoder = decoder.map_err(|e| e.to_string())?;
    check_claim(path, decoder.dimensions(), PIXELS_A_PACKED_BYTE)?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Pixels { width, height, channels: 3, values: image.into_rgb32f().into_raw(), encoded: false })
}

/// Most pixels that a byte of JPEG or BMP can hold: a block of 8×8 takes at least a bit in the one, and a run
/// of 255 two bytes in the other.
const PIXELS_A_BYTE: u64 = 512;

/// The same of PNG and HDR, with room to spare: deflate makes 1032 bytes of one, each of up to 8 pixels, and a
/// run of Radiance's first kind repeats a texel through a whole row.
const PIXELS_A_PACKED_BYTE: u64 = 1 << 14;

/// Refuses a file that claims more pixels than one of its length can hold, before there is memory for them:
/// the decoders of JPEG and BMP fill in what is missing, however much that is.
fn check_claim(path: &Path, (width, height): (u32, u32), pixels_a_byte: u64) -> Result<(), String> {
    let bytes = std::fs::metadata(path).map_err(|e| e.to_string())?.len();
    match u64::from(width) * u64::from(height) > pixels_a_byte.saturating_mul(bytes) {
        true => Err(format!("it claims {width} × {height} pixels, and has {bytes} bytes")),
        false => Ok(()),
    }
}

/// Refuses a JPEG without its last marker: the decoder fills in the rest of one that is cut short.
///
/// A file is segments of a marker, a length and as many bytes; that of a scan is followed by data in which FF stands
/// before 00 or before a marker that restarts it (ITU T.81, B.1).
fn check_end_of_jpeg(path: &Path) -> Result<(), String> {
    const START: u8 = 0xd8;
    const END: u8 = 0xd9;
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let mut at = 0;
    while let [first, second, ..] = bytes[at.min(bytes.len())..] {
        at += match (first, second) {
            (0xff, END) => return Ok(()),
            (0xff, START | 0x01 | 0xd0..=0xd7) => 2,
            // Bytes FF fill up before a marker.
            (0xff, 0xff) => 1,
            (0xff, marker) if marker != 0 => match bytes.get(at + 2..at + 4) {
                Some([high, low]) => 2 + usize::from(u16::from_be_bytes([*high, *low])),
                _ => break,
            },
            // Data of the scan.
            _ => 1,
        };
    }
    Err("the file ends before its picture does".into())
}

fn other_pixels(path: &Path) -> Result<Pixels, String> {
    let reader =
        image::ImageReader::open(path).and_then(|r| r.with_guessed_format()).map_err(|e| e.to_string())?;
    let is_jpeg = reader.format() == Some(image::ImageFormat::Jpeg);
    let pads = is_jpeg || reader.format() == Some(image::ImageFormat::Bmp);
    let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    check_claim(path, decoder.dimensions(), if pads { PIXELS_A_BYTE } else { PIXELS_A_PACKED_BYTE })?;
    if is_jpeg {
        check_end_of_jpeg(path)?;
    }
    let image = image::DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let color = image.color();
    let is_float = matches!(color, image::ColorType::Rgb32F | image::ColorType::Rgba32F);
    let (channels, values) = if color.has_color() {
        (3, image.into_rgb32f().into_raw())
    } else if color.bytes_per_pixel() / color.channel_count() == 2 {
        (1, image.into_luma16().into_raw().iter().map(|&v| v as f32 / 65535.0).collect())
    } else {
        (1, image.into_luma8().into_raw().iter().map(|&v| v as f32 / 255.0).collect())
    };
    Ok(Pixels { width, height, channels, values, encoded: !is_float })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_claims_more_than_it_can_hold_is_refused() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/fuzz/regressions");
        for (file, claim) in
            [("claims-too-many.jpg", "55299 × 194 pixels"), ("claims-too-many.bmp", "3 × 16777214 pixels")]
        {
            assert!(pixels(&folder.join(file)).err().unwrap().contains(claim), "{file}");
        }
        let folder = tempfile::tempdir().unwrap();
        let vast = folder.path().join("vast.hdr");
        std::fs::write(&vast, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000 +X 2000000\nabcd").unwrap();
        assert!(pixels(&vast).err().unwrap().contains("2000000 × 2000000 pixels"));
    }

    #[test]
    fn a_jpeg_that_is_cut_short_is_refused() {
        let whole =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/references/scenes/textures/smooth.jpg");
        let bytes = std::fs::read(&whole).unwrap();
        assert!(pixels(&whole).is_ok());
        let folder = tempfile::tempdir().unwrap();
        let cut = folder.path().join("cut.jpg");
        for length in [bytes.len() - 2, bytes.len() * 3 / 4, bytes.len() / 2] {
            std::fs::write(&cut, &bytes[..length]).unwrap();
            assert!(pixels(&cut).is_err(), "{length}");
        }
        // A preview within an application's segment has an end of its own, and what follows the end is no matter.
        let preview = [&[0xff, 0xe1, 0, 6, 0xff, 0xd8, 0xff, 0xd9], &bytes[2..bytes.len() - 2]].concat();
        std::fs::write(&cut, [&bytes[..2], &preview].concat()).unwrap();
        assert!(pixels(&cut).is_err_and(|e| e.contains("ends before")));
        std::fs::write(&cut, [&bytes[..2], &preview, &[0xff, 0xd9, 0, 0]].concat()).unwrap();
        assert!(pixels(&cut).is_ok());
    }

    #[test]
    fn a_file_is_what_it_contains() {
        let of_repository = |file: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let read = |file: &str| std::fs::read(of_repository(file)).unwrap();
        let files = [
            ("exr", read("validation/references/adapters.rgb.exr")),
            ("bmp", read("validation/fuzz/seeds/picture/texels.bmp")),
            ("png", read("docs/images/reuse.png")),
            ("hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\nabcd".to_vec()),
        ];
        let folder = tempfile::tempdir().unwrap();
        for (ending, bytes) in files {
            let found = |name: &str| {
                let file = folder.path().join(name);
                std::fs::write(&file, &bytes).unwrap();
                pixels(&file).map(|found| found.values)
            };
            let known = found(&format!("x.{ending}"));
            assert!(known.is_ok(), "{ending}: {known:?}");
            for other in ["x.png", "x.xyz", "x"] {
                assert_eq!(found(other), known, "{ending} as {other}");
            }
        }
    }

    #[test]
    fn a_bmp_is_turned_the_right_way_up_and_its_colours_are_encoded() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/fuzz/seeds/picture/texels.bmp");
        let found = pixels(&file).unwrap();
        assert_eq!((found.width, found.height, found.channels, found.encoded), (3, 2, 3, true));
        let first = [255, 0, 0, 0, 255, 0, 0, 0, 255];
        let second = [10, 20, 30, 128, 128, 128, 255, 255, 255];
        let bytes: Vec<u8> = found.values.iter().map(|v| (255.0 * v).round() as u8).collect();
        assert_eq!(bytes, [first, second].concat());
    }
}
