//! The CIE 1931 observer, the illuminant D65, and linear sRGB.

use super::table::Tabulated;
use std::sync::LazyLock;

/// The visible range, in nm.
pub const WAVELENGTH_MIN: f32 = 360.0;
/// The last wavelength of visible light, in nm.
pub const WAVELENGTH_MAX: f32 = 830.0;

/// The integral of ȳ in nm that Mitsuba 3.9 normalises by. That of its table is 106.857: a spectrum of 1
/// everywhere has luminance 1.001, in Mitsuba and here.
pub const Y_INTEGRAL: f64 = 106.750_259_399_414_06;

/// Entries of the 5 nm tables.
pub const SAMPLES: usize = 95;
const STEP: f32 = 5.0;

struct Tables {
    xyz: [[f32; 4]; SAMPLES],
    d65: [f32; SAMPLES],
    response: [[f32; 4]; SAMPLES],
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let mut tables = Tables { xyz: [[0.0; 4]; SAMPLES], d65: [0.0; SAMPLES], response: [[0.0; 4]; SAMPLES] };
    for (i, row) in rows(include_str!("data/cie1931.csv")).enumerate() {
        tables.xyz[i] = [row[1], row[2], row[3], 0.0];
    }
    for (i, row) in rows(include_str!("data/d65.csv")).enumerate() {
        tables.d65[i] = row[1];
        let [x, y, z, _] = tables.xyz[i].map(f64::from);
        let [r, g, b] = xyz_to_rgb([x, y, z]).map(|v| v as f32);
        tables.response[i] = [r, g, b, row[1]];
    }
    tables
});

fn rows(csv: &'static str) -> impl Iterator<Item = Vec<f32>> {
    csv.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').filter_map(|w| w.parse().ok()).collect())
}

/// The interval of the 5 nm tables a wavelength is in, and how far along; `None` outside the visible range.
#[inline]
fn interval(λ: f32) -> Option<(usize, f32)> {
    if !(WAVELENGTH_MIN..=WAVELENGTH_MAX).contains(&λ) {
        return None;
    }
    let t = (λ - WAVELENGTH_MIN) / STEP;
    let i = (t as usize).min(SAMPLES - 2);
    Some((i, t - i as f32))
}

/// x̄, ȳ, z̄ at a wavelength in nm.
#[inline]
pub fn xyz(λ: f32) -> [f32; 3] {
    let Some((i, t)) = interval(λ) else { return [0.0; 3] };
    let (a, b) = (&TABLES.xyz[i], &TABLES.xyz[i + 1]);
    [0, 1, 2].map(|c| a[c] * (1.0 - t) + b[c] * t)
}

/// D65 of luminance 1 at a wavelength in nm.
#[inline]
pub fn d65(λ: f32) -> f32 {
    let Some((i, t)) = interval(λ) else { return 0.0 };
    TABLES.d65[i] * (1.0 - t) + TABLES.d65[i + 1] * t
}

/// The largest value of [`d65`].
pub fn d65_bound() -> f32 {
    TABLES.d65.iter().copied().fold(0.0, f32::max)
}

/// The colour matching functions taken to linear sRGB, and D65 of luminance 1, lane by lane: r̄, ḡ, b̄, D65.
///
/// Interpolation and change of basis commute, so this is [`xyz_to_rgb`] of [`xyz`], by one look-up in a
/// table.
#[inline]
pub fn responses<const N: usize>(nm: &[f32; N]) -> [[f32; N]; 4] {
    let table = &TABLES.response;
    let mut lanes = [[0.0; N]; 4];
    for (lane, λ) in nm.iter().enumerate() {
        let Some((i, t)) = interval(*λ) else { continue };
        for c in 0..4 {
            lanes[c][lane] = table[i][c] * (1.0 - t) + table[i + 1][c] * t;
        }
    }
    lanes
}

/// XYZ to linear sRGB (BT.709 primaries, D65 white), with the matrix that Mitsuba uses.
#[inline]
pub fn xyz_to_rgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240479 * x - 1.537150 * y - 0.498535 * z,
        -0.969256 * x + 1.875991 * y + 0.041556 * z,
        0.055648 * x - 0.204043 * y + 1.057311 * z,
    ]
}

/// Linear sRGB to XYZ, by rows: the inverse of [`xyz_to_rgb`] to the six digits that both are printed with.
pub const RGB_TO_XYZ: [[f64; 3]; 3] =
    [[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]];

/// Relative luminance of linear sRGB.
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    let [_, [by_r, by_g, by_b], _] = RGB_TO_XYZ;
    by_r * r + by_g * g + by_b * b
}

/// The colour in RGB mode of a table that is an emission.
///
/// Follows Mitsuba's sum of 1000 points, which counts the range 1000/999 times; the same file must mean the
/// same.
pub fn emission_to_rgb(table: &Tabulated) -> [f64; 3] {
    table_to_rgb(table, |_| 1.0)
}

/// The same of a reflectance, which is seen under D65.
pub fn reflectance_to_rgb(table: &Tabulated) -> [f64; 3] {
    table_to_rgb(table, |λ| d65(λ).into())
}

/// The colour of a smooth spectrum that is zero outside of a range of wavelengths in nm, by the midpoint rule.
pub fn integral_to_rgb((first, last): (f32, f32), value: impl Fn(f32) -> f64) -> [f64; 3] {
    const STEPS: usize = 1000;
    let (first, last) = (first.max(WAVELENGTH_MIN), last.min(WAVELENGTH_MAX));
    let step = (last - first).max(0.0) / STEPS as f32;
    let middles = (0..STEPS).map(|i| first + step * (i as f32 + 0.5));
    xyz_to_rgb(sum_of_xyz(middles, value).map(|v| v * f64::from(step) / Y_INTEGRAL))
}

fn table_to_rgb(table: &Tabulated, illuminant: impl Fn(f32) -> f64) -> [f64; 3] {
    const STEPS: usize = 1000;
    let points = (0..STEPS)
        .map(|i| WAVELENGTH_MIN + i as f32 / (STEPS - 1) as f32 * (WAVELENGTH_MAX - WAVELENGTH_MIN));
    let scale = (WAVELENGTH_MAX - WAVELENGTH_MIN) as f64 / (Y_INTEGRAL * STEPS as f64);
    xyz_to_rgb(sum_of_xyz(points, |λ| table.eval(λ) as f64 * illuminant(λ)).map(|v| v * scale))
}

/// The sum over wavelengths in nm of a spectrum's values times the colour matching functions.
fn sum_of_xyz(wavelengths: impl Iterator<Item = f32>, value: impl Fn(f32) -> f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for λ in wavelengths {
        let value = value(λ);
        sum.iter_mut().zip(xyz(λ)).for_each(|(sum, matching)| *sum += f64::from(matching) * value);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The colour of a spectrum that is linear between the table's wavelengths: Simpson's rule is exact for
    /// it times the observer.
    fn color(spectrum: impl Fn(f32) -> f32) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for i in 0..2 * SAMPLES - 1 {
            let λ = WAVELENGTH_MIN + 2.5 * i as f32;
            let simpson = if i == 0 || i == 2 * SAMPLES - 2 { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            for (sum, matching) in sum.iter_mut().zip(xyz(λ)) {
                *sum += simpson * 2.5 / 3.0 * matching as f64 * spectrum(λ) as f64 / Y_INTEGRAL;
            }
        }
        xyz_to_rgb(sum)
    }

    #[test]
    fn light_has_the_colours_it_has_in_mitsuba() {
        // Integrals over Mitsuba 3.9.1's `d65` and `uniform` in scalar_spectral, evaluated every 0.05 nm in
        // f32.
        for (got, expected) in color(d65).iter().zip([0.999_987_1, 0.999_874_1, 0.999_798_4]) {
            assert!((got - expected).abs() < 1e-6, "{got}");
        }
        for (got, expected) in color(|_| 1.0).iter().zip([1.206_089_9, 0.949_177_2, 0.910_173_9]) {
            assert!((got - expected).abs() < 1e-6, "{got}");
        }
    }

    #[test]
    fn tables_have_the_colours_that_mitsuba_gives_them() {
        let table = Tabulated::new(vec![400.0, 550.0, 700.0], vec![0.5, 0.2, 0.3]).unwrap();
        // mitsuba.spectrum_list_to_srgb, which prints six digits.
        for (found, rgb) in [
            (emission_to_rgb(&table), [0.286217, 0.210631, 0.377384]),
            (reflectance_to_rgb(&table), [0.234136, 0.223745, 0.410219]),
        ] {
            for (got, expected) in found.iter().zip(rgb) {
                assert!((got - expected).abs() < 1e-6, "{got} {expected}");
            }
        }
    }

    /// The luminances of the primaries are what a sum of wavelengths with ȳ gives: ITU-R BT.709, not BT.601.
    #[test]
    fn luminance_is_y_of_the_colour() {
        for (rgb, expected) in
            [([1.0, 0.0, 0.0], 0.2126), ([0.0, 1.0, 0.0], 0.7152), ([0.0, 0.0, 1.0], 0.0722)]
        {
            assert!((luminance(rgb) - expected).abs() < 1e-4, "{rgb:?}");
        }
    }

    #[test]
    fn the_two_matrices_are_inverse() {
        for unit in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let back = xyz_to_rgb(RGB_TO_XYZ.map(|row| (0..3).map(|i| row[i] * unit[i]).sum()));
            // Six digits each, amplified by the largest entry of 3.2.
            assert!(back.iter().zip(unit).all(|(a, b)| (a - b).abs() < 1e-5), "{back:?}");
        }
    }

    #[test]
    fn outside_the_visible_range_there_is_nothing() {
        assert_eq!((xyz(359.0), d65(831.0), xyz(f32::NAN)), ([0.0; 3], 0.0, [0.0; 3]));
        assert!(xyz(555.0)[1] > 0.99);
    }
}
