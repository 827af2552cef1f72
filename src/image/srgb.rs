//! The transfer curve of sRGB (IEC 61966-2-1).

use crate::math::function::pow;
use std::sync::LazyLock;

/// Encoded to linear; both 0 to 1.
pub fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { pow((encoded + 0.055) / 1.055, 2.4) }
}

/// The code of a linear value in 0..1, rounded to the nearest of 256. Values outside are clamped.
pub fn encode_srgb(linear: f32) -> u8 {
    let linear = f64::from(linear).clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * pow(linear, 1.0 / 2.4) - 0.055 };
    (255.0 * encoded + 0.5) as u8
}

/// The linear values of the 8-bit codes, by [`decode`].
static CODES: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| decode(f64::from(of_code(i as u8))) as f32));

fn of_code(code: u8) -> f32 {
    f32::from(code) / 255.0
}

/// [`decode`] for a channel of a picture, with a table for 8-bit values, which most are: computing a power
/// for each would take half the time of loading a textured scene.
pub fn decode_channel(encoded: f32) -> f32 {
    let code = (encoded * 255.0 + 0.5) as u8;
    if of_code(code) == encoded { CODES[usize::from(code)] } else { decode(f64::from(encoded)) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_meets_its_known_points_and_the_encoder() {
        assert!((decode(0.5) - 0.214_041).abs() < 1e-6);
        for code in 0..=255u8 {
            assert_eq!(encode_srgb(decode(code as f64 / 255.0) as f32), code);
        }
    }

    #[test]
    fn values_outside_are_clamped() {
        assert_eq!([-1.0, -0.0, 1.0, 1e30].map(encode_srgb), [0, 0, 255, 255]);
        assert!((0..1000).map(|i| encode_srgb(i as f32 / 999.0)).is_sorted());
    }

    #[test]
    fn channels_are_decoded_alike_whether_looked_up_or_not() {
        for i in 0..=65_535u16 {
            let encoded = f32::from(i) / 65_535.0;
            assert_eq!(decode_channel(encoded), decode(f64::from(encoded)) as f32, "{i}");
        }
        for odd in [-0.5f32, -0.0, 1.5, 300.0, f32::from_bits(of_code(100).to_bits() + 1)] {
            assert_eq!(decode_channel(odd), decode(f64::from(odd)) as f32, "{odd}");
        }
    }
}
