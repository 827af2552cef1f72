//! Colour as paths carry it: eight lanes, each a wavelength of the same path, or three of them R, G and B.
//!
//! *How a new kind of constant spectrum is added*: a variant of [`function::SpectralFunction`] and its
//! `eval`.

pub mod blackbody;
pub mod distribution;
mod fit;
pub mod function;
pub mod importance;
pub mod lanes;
pub mod materials;
pub mod observer;
pub mod table;
pub mod upsample;
pub mod wavelengths;

pub use function::SpectralFunction;
pub use lanes::{LANES, Spectrum};
pub use wavelengths::Wavelengths;

use serde::Deserialize;
use std::str::FromStr;

/// Whether lanes are wavelengths or the channels R, G, B.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorMode {
    #[default]
    Spectral,
    Rgb,
}

impl ColorMode {
    /// The lanes' wavelengths, from a number in [0, 1), or the three channels.
    #[inline(always)]
    pub fn wavelengths(self, u: f64) -> Wavelengths {
        match self {
            Self::Spectral => Wavelengths::sample_visible(u),
            Self::Rgb => Wavelengths::rgb(),
        }
    }

    /// The word on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spectral => "spectral",
            Self::Rgb => "rgb",
        }
    }
}

impl FromStr for ColorMode {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let mode = [Self::Spectral, Self::Rgb].into_iter().find(|mode| mode.name() == word);
        mode.ok_or("expected `spectral` or `rgb`")
    }
}
