//! An image as a file stores it, for textures and environment maps.

use super::{read, srgb};
use std::path::Path;

/// A decoded image: rows from the top, one or three channels.
#[derive(Debug)]
pub struct Pixels {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    /// Values as stored: sRGB-encoded if `encoded`, else linear.
    pub values: Vec<f32>,
    pub encoded: bool,
}

impl Pixels {
    /// Decodes a file by its ending; the error names it.
    pub fn read(path: &Path) -> Result<Self, String> {
        read::pixels(path).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// The linear values of a texel: one channel three times over, or three.
    pub fn linear(&self, texel: usize, raw: bool) -> [f32; 3] {
        match self.channels {
            1 => [self.decoded(self.values[texel], raw); 3],
            _ => [0, 1, 2].map(|c| self.decoded(self.values[3 * texel + c], raw)),
        }
    }

    /// The linear value for one that is stored.
    pub fn decoded(&self, value: f32, raw: bool) -> f32 {
        if self.encoded && !raw { srgb::decode_channel(value) } else { value }
    }
}
