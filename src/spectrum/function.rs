//! Spectra that do not vary over a surface.

use super::blackbody::Blackbody;
use super::observer;
use super::table::Tabulated;
use super::upsample::Sigmoid;
use super::{LANES, Spectrum, Wavelengths};
use std::sync::Arc;

/// A function of wavelength, resolved for one colour mode.
#[derive(Clone, Debug)]
pub enum SpectralFunction {
    /// The same at every wavelength, or in every channel.
    Uniform(f32),
    /// R, G, B; in RGB mode every spectrum that is not uniform becomes this.
    Rgb([f32; 3]),
    /// A reflectance made from RGB.
    Sigmoid(Sigmoid),
    /// `scale` × a reflectance made from RGB: an amount that is neither reflectance nor light, such as an
    /// index of refraction.
    Scaled { scale: f32, color: Sigmoid },
    /// `scale` × a reflectance made from RGB × D65 of luminance 1: an emission made from RGB.
    Illuminant { scale: f32, color: Sigmoid },
    /// Measured values.
    Table(Arc<Tabulated>),
    /// `scale` × the table × D65 of luminance 1.
    TableUnderD65 { scale: f32, table: Arc<Tabulated> },
    /// Thermal radiation.
    Blackbody(Arc<Blackbody>),
}

impl SpectralFunction {
    #[inline]
    pub fn eval(&self, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Uniform(value) => Spectrum::splat(*value),
            Self::Rgb([r, g, b]) => Spectrum([*r, *g, *b, 0.0, 0.0, 0.0, 0.0, 0.0]),
            Self::Sigmoid(sigmoid) => Spectrum(sigmoid.eval_lanes(&λ.nm)),
            _ => self.eval_others(λ),
        }
    }

    /// [`SpectralFunction::eval`] for emission, which is usually made from RGB.
    #[inline]
    pub fn eval_light(&self, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Illuminant { scale, color } => illuminant(*scale, color, λ),
            _ => self.eval(λ),
        }
    }

    /// [`SpectralFunction::eval`] of less common spectra, out of the way of the common reflectances.
    #[inline(never)]
    fn eval_others(&self, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Uniform(_) | Self::Rgb(_) | Self::Sigmoid(_) => self.eval(λ),
            Self::Scaled { scale, color } => {
                let color = color.eval_lanes(&λ.nm);
                Spectrum::from_fn(|i| scale * color[i])
            }
            Self::Illuminant { scale, color } => illuminant(*scale, color, λ),
            Self::Table(table) => Spectrum::from_fn(|i| table.eval(λ.nm[i])),
            Self::TableUnderD65 { scale, table } => {
                Spectrum::from_fn(|i| scale * table.eval(λ.nm[i]) * λ.d65[i])
            }
            Self::Blackbody(body) => Spectrum::from_fn(|i| body.eval(λ.nm[i])),
        }
    }

    /// The value, if it is the same in all lanes.
    pub fn constant(&self) -> Option<f32> {
        match self {
            Self::Uniform(value) => Some(*value),
            Self::Rgb([r, g, b]) if r == g && g == b => Some(*r),
            _ => None,
        }
    }

    /// The mean over the visible range, or over the channels: a weight for choosing between lobes and lights.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Rgb(rgb) => rgb.iter().map(|&v| v as f64).sum::<f64>() / 3.0,
            _ => over_the_visible(|λ| self.eval(λ).sum() as f64 / LANES as f64),
        }
    }

    /// The largest value in the visible range, or of a channel.
    pub fn peak(&self) -> f32 {
        match self {
            Self::Uniform(value) => *value,
            Self::Rgb(rgb) => rgb.iter().fold(0.0, |most, v| v.max(most)),
            Self::Sigmoid(_) => 1.0,
            _ => {
                let largest = |λ: &Wavelengths| self.eval(λ).0.into_iter().fold(0.0, f32::max);
                visible().map(|λ| largest(&λ)).fold(0.0, f32::max)
            }
        }
    }

    /// Luminance under D65 of luminance 1; for a reflectance, relative to white.
    pub fn luminance(&self) -> f64 {
        match self {
            Self::Rgb(rgb) => observer::luminance(rgb.map(f64::from)),
            _ => {
                let lit = |λ: &Wavelengths, s: Spectrum| observer::luminance(λ.to_rgb(s * Spectrum(λ.d65)));
                over_the_visible(|λ| lit(λ, self.eval(λ))) / over_the_visible(|λ| lit(λ, Spectrum::ONE))
            }
        }
    }
}

#[inline(always)]
fn illuminant(scale: f32, color: &Sigmoid, λ: &Wavelengths) -> Spectrum {
    let color = color.eval_lanes(&λ.nm);
    Spectrum::from_fn(|i| scale * color[i] * λ.d65[i])
}

/// Number of sets of [`LANES`] wavelengths that [`visible`] makes.
const STEPS: usize = 16;

/// 128 wavelengths, evenly spaced in the visible range.
fn visible() -> impl Iterator<Item = Wavelengths> {
    (0..STEPS).map(|step| {
        let u = (step as f64 + 0.5) / (STEPS * LANES) as f64;
        Wavelengths::sample_uniform(u, observer::WAVELENGTH_MIN, observer::WAVELENGTH_MAX)
    })
}

/// The mean of an estimate over the wavelengths of [`visible`].
fn over_the_visible(estimate: impl Fn(&Wavelengths) -> f64) -> f64 {
    visible().map(|λ| estimate(&λ)).sum::<f64>() / STEPS as f64
}
