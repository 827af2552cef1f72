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
    /// Thermal radiation.
    Blackbody(Arc<Blackbody>),
}

impl SpectralFunction {
    /// The value in each lane: at its wavelength, or in its channel.
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
    ///
    /// What is zero in all of the visible range may still light a spectral film whose bands lie outside. Then
    /// it is the mean over its own range, or a bound of it: 0 only if the function is zero everywhere.
    pub fn mean(&self) -> f64 {
        let visible = self.visible_mean();
        match self {
            Self::Table(table) if visible == 0.0 => {
                let (first, last) = table.range();
                table.mean(first, last)
            }
            Self::Blackbody(body) if visible == 0.0 => body.bound().into(),
            _ => visible,
        }
    }

    /// The mean over the visible range, or over the channels.
    pub fn visible_mean(&self) -> f64 {
        match self {
            Self::Rgb(rgb) => rgb.iter().map(|&v| v as f64).sum::<f64>() / 3.0,
            Self::Table(table) => table.mean(observer::WAVELENGTH_MIN, observer::WAVELENGTH_MAX),
            _ => over_the_visible(|λ| self.eval(λ).sum() as f64 / LANES as f64),
        }
    }

    /// No value is above this, at any wavelength or in any channel; 0 only if all are.
    pub fn bound(&self) -> f32 {
        match self {
            Self::Uniform(value) => *value,
            Self::Rgb(rgb) => rgb.iter().fold(0.0, |most, v| v.max(most)),
            Self::Sigmoid(color) => color.bound(),
            Self::Scaled { scale, color } => scale * color.bound(),
            Self::Illuminant { scale, color } => scale * color.bound() * observer::d65_bound(),
            Self::Table(table) => table.bounds().1,
            Self::Blackbody(body) => body.bound(),
        }
    }

    /// Luminance under D65 of luminance 1; for a reflectance, relative to white.
    pub fn luminance(&self) -> f64 {
        match self {
            Self::Rgb(rgb) => observer::luminance(rgb.map(f64::from)),
            Self::Table(table) => observer::luminance(observer::reflectance_to_rgb(table)),
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

#[cfg(test)]
mod tests {
    use super::super::upsample::Upsampler;
    use super::*;
    use proptest::prelude::*;

    fn tabulated(nodes: &[(f32, f32)]) -> SpectralFunction {
        let (nm, values) = nodes.iter().copied().unzip();
        SpectralFunction::Table(Arc::new(Tabulated::new(nm, values).expect("increasing")))
    }

    fn any() -> impl Strategy<Value = SpectralFunction> {
        let table = prop::collection::vec((300.0f32..900.0, 0.0f32..9.0), 2..12).prop_map(|mut nodes| {
            nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
            nodes.dedup_by_key(|node| node.0);
            nodes.push((901.0, 0.0));
            tabulated(&nodes)
        });
        let color = (prop::array::uniform3(0.0f32..1.0), 0.1f32..9.0)
            .prop_map(|(rgb, scale)| (Upsampler::shared().fit(rgb), scale));
        let body = (500.0f64..20_000.0, 300.0f32..600.0).prop_map(|(kelvin, from)| Blackbody {
            kelvin,
            scale: 1e-4,
            range: (from, from + 250.0),
        });
        prop_oneof![
            table,
            color.clone().prop_map(|(color, _)| SpectralFunction::Sigmoid(color)),
            color.clone().prop_map(|(color, scale)| SpectralFunction::Scaled { scale, color }),
            color.prop_map(|(color, scale)| SpectralFunction::Illuminant { scale, color }),
            body.prop_map(|body| SpectralFunction::Blackbody(Arc::new(body))),
        ]
    }

    proptest! {
        #[test]
        fn no_value_is_above_the_bound(function in any()) {
            for step in 0..1000 {
                let u = (f64::from(step) + 0.5) / 8000.0;
                let λ = Wavelengths::sample_uniform(u, 300.0, 900.0);
                prop_assert!(function.eval(&λ).0.into_iter().all(|value| value <= function.bound() * (1.0 + f32::EPSILON)));
            }
        }
    }

    /// A line may be as narrow as a file says, and must not fall between wavelengths that are looked at.
    #[test]
    fn no_line_is_overlooked() {
        for i in 0..400 {
            let at = 400.0 + i as f32;
            let line = tabulated(&[(at - 0.01, 0.0), (at, 8.0), (at + 0.01, 0.0)]);
            assert_eq!(line.bound(), 8.0);
            assert!((line.mean() / (0.08 / 470.0) - 1.0).abs() < 0.01, "{at}: {}", line.mean());
        }
        let warmth = tabulated(&[(850.0, 1.0), (950.0, 3.0)]);
        assert_eq!((warmth.mean(), tabulated(&[(400.0, 0.0), (950.0, 0.0)]).mean()), (2.0, 0.0));
        let ramp = tabulated(&[(260.0, 0.0), (460.0, 2.0), (930.0, 2.0)]);
        assert!((ramp.mean() - (100.0 * 1.5 + 370.0 * 2.0) / 470.0).abs() < 1e-9);
    }

    #[test]
    fn what_counts_as_a_number_is_what_is_visible() {
        let beyond = tabulated(&[(850.0, 1.0), (900.0, 1.0)]);
        let tail = tabulated(&[(360.0, 0.0), (830.0, 0.0), (830.5, 1.0), (1000.0, 1.0)]);
        assert_eq!([beyond.visible_mean(), tail.visible_mean()], [0.0; 2]);
        // Lobes and lights are chosen by more: bands of a film may lie there.
        assert!(beyond.mean() > 0.0 && tail.mean() > 0.0);
    }
}
