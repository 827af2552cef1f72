//! Colour as paths carry it: eight lanes, each a wavelength of the same path, or three of them R, G and B.
//!
//! *How a new kind of constant spectrum is added*: a variant of [`function::SpectralFunction`] and its
//! `eval`.

pub mod blackbody;
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

/// Whether lanes are wavelengths or the channels R, G, B.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorMode {
    #[default]
    Spectral,
    Rgb,
}

impl ColorMode {
    /// The word on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spectral => "spectral",
            Self::Rgb => "rgb",
        }
    }
}
