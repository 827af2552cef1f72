//! Wavelengths drawn where the eye is sensitive, from a table.
//!
//! The density is close to sech²(0.0072(λ − 538)), Mitsuba's and pbrt's (Radziszewski et al. 2009). Its
//! cumulative distribution F ∝ tanh(a(λ − c)) is inverted at `SEGMENTS` + 1 even steps; between them λ is
//! *defined* to be linear in the random number, so that the density is constant over a segment and known
//! exactly: nothing is approximated that an estimate could notice. The observer and D65, which the program
//! knows every 5 nm, are tabulated at the same places, a quarter of a nm apart where the eye is sensitive and
//! up to 4 nm where it is blind.
//!
//! The eight wavelengths of a path are an eighth of the table apart. A row holds the eight segments with the
//! same place in their eighth, so a path needs one row, in whole registers, and no gathering.

use super::LANES;
use super::observer::{self, WAVELENGTH_MAX, WAVELENGTH_MIN};
use super::wavelengths::Wavelengths;
use crate::math::function::{ln, tanh};
use std::sync::LazyLock;

const STEEPNESS: f64 = 0.0072;
const CENTRE: f64 = 538.0;

/// Segments of the cumulative distribution.
const SEGMENTS: usize = 1024;
const ROWS: usize = SEGMENTS / LANES;

/// The segments of a row, twice over: eight in a row from any of the first eight are a rotation.
type Twice = [f32; 2 * LANES];

/// A quantity that is linear over each segment.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Linear {
    start: Twice,
    step: Twice,
}

#[derive(Clone, Copy, Default)]
struct Row {
    nm: Linear,
    d65: Linear,
    /// r̄, ḡ, b̄ over 8 p(λ) ∫ȳ.
    response: [Linear; 3],
    pdf: Twice,
}

static TABLE: LazyLock<Box<[Row]>> = LazyLock::new(|| (0..ROWS).map(row).collect());

impl Linear {
    fn set(&mut self, i: usize, from: f32, to: f32) {
        self.start[i] = from;
        self.step[i] = to - from;
    }

    /// Eight values from segment `first`, at `t` of their length.
    #[inline(always)]
    fn at(&self, first: usize, t: f32) -> [f32; LANES] {
        let (start, step) = (&self.start[first..first + LANES], &self.step[first..first + LANES]);
        let mut values = [0.0; LANES];
        for i in 0..LANES {
            values[i] = start[i] + step[i] * t;
        }
        values
    }
}

/// The wavelength in nm below which the fraction `index` / [`SEGMENTS`] of the distribution lies.
fn quantile(index: usize) -> f32 {
    let [lowest, highest] =
        [WAVELENGTH_MIN, WAVELENGTH_MAX].map(|end| tanh(STEEPNESS * (end as f64 - CENTRE)));
    let x = lowest + (highest - lowest) * (index as f64 / SEGMENTS as f64);
    let nm = CENTRE + 0.5 / STEEPNESS * ln((1.0 + x) / (1.0 - x));
    (nm as f32).clamp(WAVELENGTH_MIN, WAVELENGTH_MAX)
}

fn row(index: usize) -> Row {
    let mut row = Row::default();
    for i in 0..2 * LANES {
        let segment = i % LANES * ROWS + index;
        let ends = [quantile(segment), quantile(segment + 1)];
        row.nm.set(i, ends[0], ends[1]);
        row.pdf[i] = 1.0 / ((ends[1] - ends[0]) * SEGMENTS as f32);
        let scale = Wavelengths::RESPONSE_SCALE / row.pdf[i];
        let [r, g, b, d65] = observer::responses(&ends);
        row.d65.set(i, d65[0], d65[1]);
        for (line, c) in row.response.iter_mut().zip([r, g, b]) {
            line.set(i, c[0] * scale, c[1] * scale);
        }
    }
    row
}

/// Eight wavelengths, evenly rotated in the cumulative distribution about the one that u in [0, 1) picks,
/// which is lane 0.
#[inline]
pub fn sample_visible(u: f64) -> Wavelengths {
    let place = u * SEGMENTS as f64;
    let segment = (place as usize).min(SEGMENTS - 1);
    let t = (place - segment as f64) as f32;
    let (row, first) = (&TABLE[segment % ROWS], segment / ROWS);
    let mut pdf = [0.0; LANES];
    pdf.copy_from_slice(&row.pdf[first..first + LANES]);
    Wavelengths {
        nm: row.nm.at(first, t),
        pdf,
        d65: row.d65.at(first, t),
        response: [0, 1, 2].map(|c| row.response[c].at(first, t)),
        mean_factor: 1.0 / LANES as f32,
        collapsed: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Spectrum;

    #[test]
    fn density_is_the_derivative_of_the_sampling() {
        for i in 0..1000 {
            let u = (i as f64 + 0.5) / 1000.0;
            let (a, b) = (sample_visible(u), sample_visible(u + 1e-5));
            for lane in 0..LANES {
                if a.pdf[lane] == b.pdf[lane] {
                    let step = (b.nm[lane] - a.nm[lane]) as f64;
                    // Wavelengths near 830 nm are 6e-5 nm apart in f32, and the step is at least 2e-3 nm.
                    assert!((step * a.pdf[lane] as f64 / 1e-5 - 1.0).abs() < 0.03, "{} nm", a.nm[lane]);
                }
            }
        }
    }

    #[test]
    fn lanes_are_eighths_apart_and_lane_zero_goes_everywhere() {
        assert_eq!(sample_visible(0.0).nm[0], WAVELENGTH_MIN);
        assert!(sample_visible(1.0 - 1e-9).nm[0] > WAVELENGTH_MAX - 1e-3);
        for i in 0..64 {
            let u = i as f64 / 64.0;
            let λ = sample_visible(u);
            for lane in 0..LANES {
                let expected = sample_visible((u + lane as f64 / LANES as f64).fract()).nm[0];
                assert_eq!(λ.nm[lane], expected);
            }
        }
    }

    #[test]
    fn density_is_close_to_the_curve_it_stands_for() {
        for i in 0..100 {
            let λ = sample_visible(i as f64 / 100.0);
            let at = |nm: f64| 1.0 / libm::pow(libm::cosh(STEEPNESS * (nm - CENTRE)), 2.0);
            let area = (tanh(STEEPNESS * (830.0 - CENTRE)) - tanh(STEEPNESS * (360.0 - CENTRE))) / STEEPNESS;
            let ratio = λ.pdf[0] as f64 * area / at(λ.nm[0] as f64);
            assert!((ratio - 1.0).abs() < 0.02, "{} nm: {ratio}", λ.nm[0]);
        }
    }

    #[test]
    fn equal_energy_light_has_luminance_one() {
        let n = 4096;
        let mut sum = [0.0; 3];
        for i in 0..n {
            let λ = sample_visible((i as f64 + 0.5) / n as f64);
            for (sum, c) in sum.iter_mut().zip(λ.to_rgb(Spectrum::ONE)) {
                *sum += c / n as f64;
            }
        }
        // The integral over Mitsuba 3.9.1's `uniform`; see the tests of the observer.
        for (got, expected) in sum.iter().zip([1.206_089_9, 0.949_177_2, 0.910_173_9]) {
            assert!((got - expected).abs() < 2e-5, "{sum:?}");
        }
    }
}
