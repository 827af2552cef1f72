//! Mitsuba's files of values on a grid (`.vol`, version 3, little-endian): the letters VOL, the version, an
//! encoding (1 for `f32`), cells along x, y and z, channels, the corners of a box, then the values, channels
//! first, then along x, y and z.

use crate::math::DVec3;
use crate::math::bounds::Bounds;
use std::path::Path;

const HEADER: usize = 48;
const VERSION: u8 = 3;
const FLOAT32: u32 = 1;

/// The values of a grid.
#[derive(Debug)]
pub struct Voxels {
    /// Cells along x, y and z.
    pub size: [usize; 3],
    /// One, or three for colours.
    pub channels: usize,
    /// The box that the file says the grid fills.
    pub bounds: Bounds,
    pub values: Vec<f32>,
}

impl Voxels {
    /// Reads a file; the error names it.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        parse(&bytes).map_err(|e| format!("{}: {e}", path.display()))
    }
}

fn parse(bytes: &[u8]) -> Result<Voxels, String> {
    let word = |i: usize| bytes.get(i..i + 4).and_then(|word| word.try_into().ok());
    let integer = |i: usize| word(i).map(u32::from_le_bytes).ok_or("the file ends within its header");
    let number = |i: usize| integer(i).map(f32::from_bits);
    if bytes.get(..3) != Some(b"VOL") {
        return Err("no volume file: it does not begin with VOL".into());
    }
    let version = *bytes.get(3).ok_or("the file ends within its header")?;
    if version != VERSION {
        return Err(format!("version {version} of the format; expected {VERSION}"));
    }
    let encoding = integer(4)?;
    if encoding != FLOAT32 {
        return Err(format!("encoding {encoding} of the values; expected {FLOAT32} (32-bit floats)"));
    }
    let [x, y, z, channels] = [integer(8)?, integer(12)?, integer(16)?, integer(20)?];
    if channels != 1 && channels != 3 {
        return Err(format!("{channels} channels; expected 1 or 3"));
    }
    let corner = |i: usize| -> Result<DVec3, String> {
        Ok(DVec3::new(number(i)?.into(), number(i + 4)?.into(), number(i + 8)?.into()))
    };
    let bounds = (corner(24)?, corner(36)?);
    let count = [x, y, z, channels].iter().try_fold(1u64, |n, &m| n.checked_mul(m.into()));
    let found = bytes.len() - HEADER;
    if count.and_then(|count| count.checked_mul(4)) != Some(found as u64) || found == 0 {
        let message = format!("{x} × {y} × {z} cells of {channels} channels, and {found} bytes of values");
        return Err(format!("{message}; expected four bytes for each"));
    }
    let values = bytes[HEADER..].as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    Ok(Voxels { size: [x, y, z].map(|n| n as usize), channels: channels as usize, bounds, values })
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A file of one channel over the unit cube.
    pub fn file(size: [u32; 3], channels: u32, values: &[f32]) -> Vec<u8> {
        let mut bytes = b"VOL\x03\x01\0\0\0".to_vec();
        for n in size.into_iter().chain([channels]) {
            bytes.extend(n.to_le_bytes());
        }
        for v in [0.0f32, 0.0, 0.0, 1.0, 1.0, 1.0].iter().chain(values) {
            bytes.extend(v.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn what_was_written_is_read() {
        let values: Vec<f32> = (0..24).map(|i| i as f32 * 0.5).collect();
        let voxels = parse(&file([2, 4, 3], 1, &values)).unwrap();
        assert_eq!((voxels.size, voxels.channels), ([2, 4, 3], 1));
        assert_eq!((voxels.values, voxels.bounds), (values, (DVec3::ZERO, DVec3::ONE)));
    }

    #[test]
    fn files_that_are_cut_or_strange_are_refused() {
        let whole = file([2, 2, 2], 3, &[0.5; 24]);
        for length in 0..whole.len() {
            assert!(parse(&whole[..length]).is_err(), "{length}");
        }
        let with = |at: usize, byte: u8| {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            parse(&bytes).unwrap_err()
        };
        assert!(with(0, b'X').contains("VOL"));
        assert!(with(3, 4).contains("version 4"));
        assert!(with(4, 2).contains("encoding 2"));
        assert!(with(20, 6).contains("6 channels"));
        assert!(with(8, 3).contains("3 × 2 × 2"));
        assert!(with(11, 255).contains("four bytes"));
        assert!(parse(&file([0, 1, 1], 1, &[])).unwrap_err().contains("0 × 1 × 1"));
    }
}
