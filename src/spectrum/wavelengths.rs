//! Which wavelengths a path carries, and how its lanes become colour.

use super::observer::{self, WAVELENGTH_MAX, WAVELENGTH_MIN};
use super::{ColorMode, LANES, Spectrum};
use crate::math::function::ln_lanes;

/// The wavelengths of one camera sample.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Wavelengths {
    /// Wavelength of each lane in nm; in RGB mode unused.
    pub nm: [f32; LANES],
    /// Density of each lane with respect to nm; in RGB mode 1.
    pub pdf: [f32; LANES],
    /// D65 of luminance 1 at each lane.
    pub d65: [f32; LANES],
    /// What a lane's radiance adds to R, G and B: the response over 8 p(λ) ∫ȳ.
    pub response: [[f32; LANES]; 3],
    /// 1 / (number of lanes that count in a mean): 8 wavelengths or 3 colours.
    pub mean_factor: f32,
    /// Only lane 0 is alive: a dispersive refraction has sent the other wavelengths elsewhere.
    pub collapsed: bool,
}

/// The density is proportional to sech²(0.0072(λ − 538)), as in Mitsuba and pbrt (Radziszewski et al. 2009).
const STEEPNESS: f32 = 0.0072;
const CENTRE: f32 = 538.0;

impl Wavelengths {
    /// Eight wavelengths, evenly rotated in the cumulative distribution about the one that u in [0, 1) picks.
    ///
    /// The cumulative distribution is F(λ) ∝ tanh(a(λ − c)) between its values at the ends of the range, so
    /// λ = c + artanh(x)/a with x linear in u, and the density is a(1 − x²)/(x₁ − x₀) without a further function.
    #[inline]
    pub fn sample_visible(u: f64) -> Self {
        // tanh(a(360 − c)) and tanh(a(830 − c))
        const X0: f32 = -0.856_910_6;
        const X1: f32 = 0.970_591_4;
        let x: [f32; LANES] = std::array::from_fn(|i| {
            let v = u + i as f64 / LANES as f64;
            let v = if v >= 1.0 { v - 1.0 } else { v };
            X0 + (X1 - X0) * v as f32
        });
        let logarithm = ln_lanes(x.map(|x| (1.0 + x) / (1.0 - x)));
        let nm = logarithm.map(|l| (CENTRE + 0.5 / STEEPNESS * l).clamp(WAVELENGTH_MIN, WAVELENGTH_MAX));
        Self::new(nm, x.map(|x| STEEPNESS / (X1 - X0) * (1.0 - x * x)))
    }

    #[inline(never)]
    fn new(nm: [f32; LANES], pdf: [f32; LANES]) -> Self {
        const SCALE: f32 = (1.0 / (LANES as f64 * observer::Y_INTEGRAL)) as f32;
        let [r, g, b, d65] = observer::responses(&nm);
        let scale = pdf.map(|p| SCALE / p);
        let response = [r, g, b].map(|c| std::array::from_fn(|i| c[i] * scale[i]));
        Self { nm, pdf, d65, response, mean_factor: 1.0 / LANES as f32, collapsed: false }
    }

    /// Eight wavelengths evenly spaced over [min, max) nm, for films that resolve the spectrum.
    pub fn sample_uniform(u: f64, min: f32, max: f32) -> Self {
        let nm = std::array::from_fn(|i| {
            let v = u + i as f64 / LANES as f64;
            min + (max - min) * (if v >= 1.0 { v - 1.0 } else { v }) as f32
        });
        Self::new(nm, [1.0 / (max - min); LANES])
    }

    /// The three channels of RGB mode.
    #[inline]
    pub fn rgb() -> Self {
        let mut response = [[0.0; LANES]; 3];
        (0..3).for_each(|c| response[c][c] = 1.0);
        Self {
            nm: [0.0; LANES],
            pdf: [1.0; LANES],
            d65: [1.0; LANES],
            response,
            mean_factor: 1.0 / 3.0,
            collapsed: false,
        }
    }

    pub fn mode(&self) -> ColorMode {
        if self.mean_factor == 1.0 / LANES as f32 { ColorMode::Spectral } else { ColorMode::Rgb }
    }

    /// A statistic of a spectrum that treats all lanes alike. Decisions that shape the path (lobes, roulette) rest on
    /// it: then all lanes have the same path density and need no weights between them.
    #[inline]
    pub fn mean(&self, s: Spectrum) -> f32 {
        s.sum() * self.mean_factor
    }

    /// The estimate of linear sRGB that a path's radiance (W·m⁻²·sr⁻¹·nm⁻¹) makes.
    ///
    /// Spectral: Σᵢ L(λᵢ) rgb̄(λᵢ) / (8 p(λᵢ) ∫ȳ), rgb̄ being the colour matching functions taken to sRGB.
    #[inline(always)]
    pub fn to_rgb(&self, radiance: Spectrum) -> [f64; 3] {
        self.response.map(|weights| {
            let product: [f64; LANES] = std::array::from_fn(|i| radiance.0[i] as f64 * weights[i] as f64);
            let pairs: [f64; 4] = std::array::from_fn(|i| product[i] + product[i + 4]);
            (pairs[0] + pairs[2]) + (pairs[1] + pairs[3])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn density_is_the_derivative_of_the_sampling() {
        for i in 0..1000 {
            let u = (i as f64 + 0.5) / 1000.0 / 8.0;
            let (a, b) = (Wavelengths::sample_visible(u), Wavelengths::sample_visible(u + 1e-3));
            for lane in 0..LANES {
                let step = b.nm[lane] - a.nm[lane];
                let pdf = 0.5 * (a.pdf[lane] + b.pdf[lane]);
                if step > 0.0 {
                    assert!((step * pdf / 1e-3 - 1.0).abs() < 5e-3, "{} nm", a.nm[lane]);
                }
            }
        }
    }

    #[test]
    fn equal_energy_light_has_luminance_one() {
        let n = 4096;
        let mut sum = [0.0; 3];
        for i in 0..n {
            let λ = Wavelengths::sample_visible((i as f64 + 0.5) / n as f64);
            let rgb = λ.to_rgb(Spectrum::ONE);
            for c in 0..3 {
                sum[c] += rgb[c] / n as f64;
            }
        }
        // What Mitsuba 3.9.1 makes of <spectrum value="1"/>.
        for (got, expected) in sum.iter().zip([1.2048, 0.9484, 0.9087]) {
            assert!((got - expected).abs() < 2e-3, "{sum:?}");
        }
    }
}
