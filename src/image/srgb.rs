//! The transfer curve of sRGB (IEC 61966-2-1).

use crate::math::function::pow;

/// Encoded to linear; both 0 to 1.
pub fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { pow((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_meets_its_known_points_and_the_encoder() {
        assert!((decode(0.5) - 0.214_041).abs() < 1e-6);
        for code in 0..=255u8 {
            assert_eq!(crate::image::encode_srgb(decode(code as f64 / 255.0) as f32), code);
        }
    }
}
