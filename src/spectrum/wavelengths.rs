//! The wavelengths of a path, and how its lanes become colour.

use super::{ColorMode, LANES, Spectrum};
use super::{importance, observer};
use crate::math::simd::F64x4;

/// The wavelengths of one camera sample.
#[derive(Clone, Copy, Debug)]
pub struct Wavelengths {
    /// Wavelength of each lane in nm; in RGB mode unused.
    pub nm: [f32; LANES],
    /// Density of each lane with respect to nm; in RGB mode 1.
    pub pdf: [f32; LANES],
    /// D65 of luminance 1 at each lane.
    pub d65: [f32; LANES],
    /// Factor from a lane's radiance to its contribution to R, G and B: the response over 8 p(λ) ∫ȳ.
    pub response: [[f32; LANES]; 3],
    /// 1 / (number of lanes that count in a mean): 8 wavelengths or 3 colours.
    pub mean_factor: f32,
    /// 1 where only lane 0 is alive, else 0. A number, and not a bool: this struct is copied for every path,
    /// and bytes of padding at its end would be copied one by one.
    pub(super) collapsed: u32,
}

impl Wavelengths {
    /// 1 over the number of lanes and ∫ȳ: the factor from a sum over lanes of response over density to a
    /// colour.
    pub const RESPONSE_SCALE: f32 = (1.0 / (LANES as f64 * observer::Y_INTEGRAL)) as f32;

    /// Eight wavelengths evenly spaced over [min, max) nm.
    #[inline(never)]
    pub fn sample_uniform(u: f64, min: f32, max: f32) -> Self {
        let nm = std::array::from_fn(|i| {
            let v = u + i as f64 / LANES as f64;
            min + (max - min) * (if v >= 1.0 { v - 1.0 } else { v }) as f32
        });
        let pdf = 1.0 / (max - min);
        let [r, g, b, d65] = observer::responses(&nm);
        let response = [r, g, b].map(|c| c.map(|c| c * (Self::RESPONSE_SCALE / pdf)));
        Self { nm, pdf: [pdf; LANES], d65, response, mean_factor: 1.0 / LANES as f32, collapsed: 0 }
    }

    /// Eight wavelengths drawn where the eye is sensitive; see [`super::importance`].
    #[inline]
    pub fn sample_visible(u: f64) -> Self {
        importance::sample_visible(u)
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
            collapsed: 0,
        }
    }

    /// Leaves only lane 0 alive: a dispersive refraction has sent the other wavelengths elsewhere.
    #[inline]
    pub fn collapse(&mut self) {
        self.collapsed = 1;
    }

    /// Whether only lane 0 is alive.
    #[inline]
    pub fn is_collapsed(&self) -> bool {
        self.collapsed != 0
    }

    /// Whether the lanes are wavelengths or channels.
    #[inline]
    pub fn mode(&self) -> ColorMode {
        if self.mean_factor == 1.0 / LANES as f32 { ColorMode::Spectral } else { ColorMode::Rgb }
    }

    /// 1 in each lane that counts: what a path carries before anything is taken from it. The lanes that RGB
    /// mode leaves empty are 0 here, and stay so whatever they are multiplied with, for what is the same at
    /// all wavelengths fills them too.
    #[inline(always)]
    pub fn ones(&self) -> Spectrum {
        match self.mode() {
            ColorMode::Spectral => Spectrum::ONE,
            ColorMode::Rgb => Spectrum([1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        }
    }

    /// The mean over lanes, of which those that do not count are 0. Lobes are chosen by it because it treats
    /// all lanes alike: so all lanes have the same path density and need no weights between them.
    #[inline]
    pub fn mean(&self, s: Spectrum) -> f32 {
        s.sum() * self.mean_factor
    }

    /// The largest lane, which treats all lanes alike too; of a collapsed path, the share of the one lane.
    #[inline]
    pub fn peak(&self, s: Spectrum) -> f32 {
        if self.is_collapsed() { self.mean(s) } else { s.max() }
    }

    /// The estimate of linear sRGB that a path's radiance (W·m⁻²·sr⁻¹·nm⁻¹) makes.
    ///
    /// Spectral: Σᵢ L(λᵢ) rgb̄(λᵢ) / (8 p(λᵢ) ∫ȳ), rgb̄ being the colour matching functions taken to sRGB.
    #[inline(always)]
    pub fn to_rgb(&self, radiance: Spectrum) -> [f64; 3] {
        let halves = |lanes: &[f32; LANES]| {
            let [a, b, c, d, e, f, g, h] = *lanes;
            [F64x4::widen(&[a, b, c, d]), F64x4::widen(&[e, f, g, h])]
        };
        let [low, high] = halves(&radiance.0);
        [0, 1, 2].map(|c| {
            let weights = halves(&self.response[c]);
            let pairs = (low * weights[0] + high * weights[1]).to_array();
            (pairs[0] + pairs[2]) + (pairs[1] + pairs[3])
        })
    }
}
