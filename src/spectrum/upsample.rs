//! From RGB to smooth reflectance spectra (Jakob & Hanika 2019, "A Low-Dimensional Function Space for
//! Efficient Spectral Upsampling").
//!
//! A reflectance is S(c₀λ² + c₁λ + c₂) with the sigmoid S(x) = ½ + x/(2√(1 + x²)). The coefficients of a
//! colour are interpolated in a 3 × 64³ grid laid out as in the paper's reference tables. Fitting each colour
//! by itself would be exact, but Mitsuba interpolates: at albedos of 2 % that moves the colour by some
//! percent, and the same file should mean the same spectrum. A column of the grid, all brightnesses of one
//! hue and saturation, is fitted when it is first asked for; what it holds depends on nothing but its place.

use super::{LANES, fit};
use glam::DVec3;
use std::sync::{Arc, LazyLock, OnceLock};

/// The coefficients c₀, c₁, c₂ of a reflectance, for λ in nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigmoid(pub [f32; 3]);

impl Sigmoid {
    /// The reflectance `value` at all wavelengths: x = (v − ½)/√(v(1 − v)), infinite for 0 and 1.
    pub fn grey(value: f32) -> Self {
        Self([0.0, 0.0, (value - 0.5) / (value * (1.0 - value)).sqrt()])
    }

    /// Reflectance at a wavelength in nm.
    ///
    /// The smaller of S and 1 − S is 1/(2h(h + |x|)) with h = √(1 + x²), which has no difference of like
    /// numbers.
    #[inline(always)]
    pub fn eval(&self, λ: f32) -> f32 {
        let [c0, c1, c2] = self.0;
        let x = (c0 * λ + c1) * λ + c2;
        let h = (1.0 + x * x).sqrt();
        let tail = 0.5 / (h * (h + x.abs()));
        if x < 0.0 { tail } else { 1.0 - tail }
    }

    /// No reflectance is above this.
    pub fn bound(&self) -> f32 {
        if self.0[..2] == [0.0; 2] { self.eval(0.0) } else { 1.0 }
    }

    /// Reflectance at eight wavelengths.
    #[inline(always)]
    pub fn eval_lanes(&self, nm: &[f32; LANES]) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        for (value, λ) in values.iter_mut().zip(nm) {
            *value = self.eval(*λ);
        }
        values
    }
}

const RESOLUTION: usize = 64;

/// Coefficients by brightness; the fourth number pads to a vector.
type Column = [[f32; 4]; RESOLUTION];

/// The grid of fitted colours.
pub struct Upsampler {
    /// The brightness of each layer; they are finer near black and white.
    brightness: [f32; RESOLUTION],
    /// Columns by largest component, then by the ratios of the two others to it.
    columns: Vec<OnceLock<Box<Column>>>,
}

static SHARED: LazyLock<Arc<Upsampler>> = LazyLock::new(|| Arc::new(Upsampler::new()));

impl Upsampler {
    fn new() -> Self {
        let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
        let brightness = std::array::from_fn(|k| smooth(smooth(k as f64 / (RESOLUTION - 1) as f64)) as f32);
        Self { brightness, columns: vec![OnceLock::new(); 3 * RESOLUTION * RESOLUTION] }
    }

    /// The process's one grid: fits are kept for the next scene.
    pub fn shared() -> Arc<Self> {
        SHARED.clone()
    }

    /// A colour of any brightness as a factor and a reflectance: within [0, 1] that of the colour itself, as in
    /// Mitsuba, and beyond in proportion.
    pub fn fit_in_proportion(&self, rgb: [f64; 3]) -> (f32, Sigmoid) {
        let scale = rgb.iter().fold(1.0f64, |scale, v| scale.max(*v));
        (scale as f32, self.fit(rgb.map(|v| (v / scale) as f32)))
    }

    /// The reflectance of a linear sRGB colour; components are clamped to [0, 1], and no number counts as 0.
    pub fn fit(&self, rgb: [f32; 3]) -> Sigmoid {
        let rgb = rgb.map(|v| if v > 0.0 { v.min(1.0) } else { 0.0 });
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return Sigmoid::grey(rgb[0]);
        }
        // Of equal components the last counts as the largest.
        let largest = (1..3).fold(0, |best, i| if rgb[i] >= rgb[best] { i } else { best });
        let z = rgb[largest];
        if z < 1e-36 {
            // It could as well be black, and 63/z would overflow.
            return Sigmoid::grey(0.0);
        }
        let ratio = (RESOLUTION - 1) as f32 / z;
        let (x, y) = (rgb[(largest + 1) % 3] * ratio, rgb[(largest + 2) % 3] * ratio);
        let cell = |v: f32| (v as usize).min(RESOLUTION - 2);
        let (xi, yi) = (cell(x), cell(y));
        let zi = self.brightness.partition_point(|&b| b <= z).clamp(1, RESOLUTION - 1) - 1;
        let (tx, ty) = (x - xi as f32, y - yi as f32);
        let tz = (z - self.brightness[zi]) / (self.brightness[zi + 1] - self.brightness[zi]);
        let mut c = [0.0f32; 4];
        for (dx, dy, weight) in [
            (0, 0, (1.0 - tx) * (1.0 - ty)),
            (1, 0, tx * (1.0 - ty)),
            (0, 1, (1.0 - tx) * ty),
            (1, 1, tx * ty),
        ] {
            if weight != 0.0 {
                let column = self.column(largest, xi + dx, yi + dy);
                let (below, above) = (column[zi], column[zi + 1]);
                for i in 0..4 {
                    c[i] += weight * (below[i] * (1.0 - tz) + above[i] * tz);
                }
            }
        }
        Sigmoid([c[0], c[1], c[2]])
    }

    fn column(&self, largest: usize, x: usize, y: usize) -> &Column {
        let index = (largest * RESOLUTION + y) * RESOLUTION + x;
        self.columns[index].get_or_init(|| {
            let ratio = |i: usize| i as f64 / (RESOLUTION - 1) as f64;
            let mut hue = DVec3::ZERO;
            hue[largest] = 1.0;
            hue[(largest + 1) % 3] = ratio(x);
            hue[(largest + 2) % 3] = ratio(y);
            Box::new(self.fit_column(hue))
        })
    }

    /// Fits one hue at all brightnesses: from a middle one, where no coefficient is large, up to the
    /// brightest and down to black, each fit starting where the one before it ended.
    fn fit_column(&self, hue: DVec3) -> Column {
        const MIDDLE: usize = RESOLUTION / 5;
        let mut column = [[0.0; 4]; RESOLUTION];
        let mut run = |layers: &mut dyn Iterator<Item = usize>| {
            let mut c = DVec3::ZERO;
            for k in layers {
                c = fit::gauss_newton(hue * self.brightness[k] as f64, c);
                let [c0, c1, c2] = fit::in_nm(c);
                column[k] = [c0, c1, c2, 0.0];
            }
        };
        run(&mut (MIDDLE..RESOLUTION));
        run(&mut (0..=MIDDLE).rev());
        column
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::observer;
    use crate::spectrum::table::Tabulated;

    /// The colour under D65, relative to white: the sum over a table of the sigmoid every nm.
    fn color_of(sigmoid: Sigmoid) -> [f64; 3] {
        let rgb = |s: Sigmoid| {
            let values = (360..=830).map(|nm| s.eval(nm as f32)).collect();
            let table = Tabulated::regular(observer::WAVELENGTH_MIN, observer::WAVELENGTH_MAX, values);
            observer::reflectance_to_rgb(&table.unwrap())
        };
        let (color, white) = (rgb(sigmoid), rgb(Sigmoid::grey(1.0)));
        [0, 1, 2].map(|i| color[i] / white[i])
    }

    #[test]
    fn the_least_colours_have_spectra() {
        for rgb in [
            [0.0, 0.0, 1e-40],
            [1e-40, 1e-40, 2e-40],
            [1e-45, 0.0, 0.0],
            [0.0, 1e-30, 2e-36],
            [0.0, 1.1e-36, 1e-36],
        ] {
            let sigmoid = Upsampler::shared().fit(rgb);
            for λ in [360.0, 500.0, 830.0] {
                let value = sigmoid.eval(λ);
                assert!((0.0..1e-2).contains(&value), "{rgb:?} at {λ}: {value}");
            }
        }
    }

    #[test]
    fn colours_come_back() {
        let upsampler = Upsampler::shared();
        for i in 0..6 {
            for j in 0..6 {
                for k in 0..6 {
                    let rgb = [i, j, k].map(|v| v as f32 * 0.18 + 0.02);
                    let back = color_of(upsampler.fit(rgb));
                    for c in 0..3 {
                        // What interpolating in the grid costs; Mitsuba's table errs as much.
                        assert!((back[c] - rgb[c] as f64).abs() < 2e-3, "{rgb:?} {back:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn spectra_are_those_of_mitsuba() {
        // `srgb` in Mitsuba 3.9.1's scalar_spectral at 450, 560 and 650 nm: pale, saturated, at the rim of
        // the gamut, nearly white, nearly grey and dark colours.
        for (rgb, expected) in [
            ([0.2, 0.5, 0.7], [0.68059, 0.447898, 0.189964]),
            ([0.8, 0.1, 0.1], [0.104154, 0.149503, 0.941978]),
            ([1.0, 0.0, 0.0], [0.010658, 0.0201935, 0.997359]),
            ([0.0, 0.0, 1.0], [0.973683, 0.0173176, 0.011467]),
            ([0.0, 0.5, 1.0], [0.949606, 0.350974, 0.133955]),
            ([0.98, 0.9, 0.95], [0.951735, 0.912225, 0.980862]),
            ([0.5, 0.5, 0.499], [0.499118, 0.500034, 0.499739]),
            ([0.01, 0.002, 0.03], [0.0165477, 0.00456196, 0.00892339]),
            ([0.001, 0.002, 0.0005], [0.000546398, 0.00203826, 0.000545677]),
        ] {
            let sigmoid = Upsampler::shared().fit(rgb);
            for (λ, expected) in [450.0, 560.0, 650.0].into_iter().zip(expected) {
                // Both fits stop at 1e-3 in CIELAB, which is 1e-5 in a bright reflectance and less in a dark
                // one.
                let error = (sigmoid.eval(λ) - expected).abs();
                assert!(error < 2e-5 + 1e-3 * expected.min(1.0 - expected), "{rgb:?} {λ} {error}");
            }
        }
    }

    #[test]
    fn grey_is_flat_and_exact() {
        let upsampler = Upsampler::shared();
        for v in [0.0, 1e-30, 1e-6, 0.02, 0.5, 0.8, 0.999_999, 1.0] {
            for λ in [360.0, 550.0, 830.0] {
                let got = upsampler.fit([v; 3]).eval(λ);
                // x is rounded to a few parts in 2²⁴, and S or 1 − S is proportional to 1/x² far out.
                assert!((got - v).abs() <= 1e-6 * v.min(1.0 - v), "{v}: {got}");
            }
        }
    }

    #[test]
    fn what_is_no_reflectance_is_clamped() {
        let upsampler = Upsampler::shared();
        assert_eq!(upsampler.fit([f32::NAN, -1.0, 0.0]), upsampler.fit([0.0; 3]));
        assert_eq!(upsampler.fit([2.0, 0.5, 0.1]), upsampler.fit([1.0, 0.5, 0.1]));
    }
}
