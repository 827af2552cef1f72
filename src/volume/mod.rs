//! Values that may vary in space. Wherever a scene file may give one, it may give a constant colour or
//! spectrum as well.
//!
//! *How to add one*: write `volume/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line to
//! [`VOLUMES`] and a variant to [`AnyVolume`].

mod constvolume;
mod file;
mod gridvolume;

use crate::math::{DVec3, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::{Entry, construct};
use crate::scene::xml::Element;
use crate::spectrum::{SpectralFunction, Spectrum, Wavelengths};
use crate::texture::AnyTexture;
pub use constvolume::Constant;
pub use file::Voxels;
#[cfg(test)]
pub use file::tests::file as file_of;
pub use gridvolume::Grid;

/// Any volume.
#[derive(Clone, Debug)]
pub enum AnyVolume {
    Constant(Box<Constant>),
    Grid(Box<Grid>),
}

macro_rules! volumes {
    ($($module:ident),* $(,)?) => {
        /// Every volume.
        pub static VOLUMES: &[Entry<AnyVolume>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: $module::parse,
        }),*];
    };
}
volumes!(constvolume, gridvolume);

impl AnyVolume {
    /// Reads the parameter `name`: a `<volume>`, or a colour or spectrum that is the same everywhere.
    pub fn parameter(
        params: &mut Params,
        name: &'static str,
        default: f64,
        usage: Usage,
        about: &'static str,
    ) -> Result<Self, SceneError> {
        match params.raw(name, "volume", &default.to_string(), about)? {
            None => Ok(Self::everywhere(SpectralFunction::Uniform(default as f32))),
            Some(element) if element.tag == "volume" => construct(VOLUMES, element, params.loader, usage),
            Some(element) => {
                let texture = AnyTexture::parse(element, params.loader, usage)?;
                constant(texture, element).map(Self::everywhere)
            }
        }
    }

    /// The same value everywhere.
    fn everywhere(value: SpectralFunction) -> Self {
        Self::Constant(Box::new(Constant { value, to_world: Transform::IDENTITY }))
    }

    /// The value at a point (world).
    #[inline]
    pub fn eval(&self, p: DVec3, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Constant(constant) => constant.value.eval(λ),
            Self::Grid(grid) => grid.eval(p, λ),
        }
    }

    /// Whether the value is one number for all wavelengths.
    pub fn is_scalar(&self) -> bool {
        match self {
            Self::Constant(constant) => matches!(constant.value, SpectralFunction::Uniform(_)),
            Self::Grid(grid) => grid.is_scalar(),
        }
    }

    /// The value at a point (world) of a volume that [is a number](Self::is_scalar).
    #[inline]
    pub fn eval_scalar(&self, p: DVec3) -> f64 {
        f64::from(self.eval(p, &Wavelengths::rgb()).0[0])
    }

    /// The value, if it is the same everywhere.
    pub fn constant(&self) -> Option<&SpectralFunction> {
        match self {
            Self::Constant(constant) => Some(&constant.value),
            Self::Grid(_) => None,
        }
    }

    /// From the unit cube to where the values are meant to be.
    pub fn to_world(&self) -> &Transform {
        match self {
            Self::Constant(constant) => &constant.to_world,
            Self::Grid(grid) => grid.to_world(),
        }
    }

    /// How many cells along each axis of the unit cube have values of their own.
    pub fn resolution(&self) -> [usize; 3] {
        match self {
            Self::Constant(_) => [1; 3],
            Self::Grid(grid) => grid.resolution(),
        }
    }

    /// No value in a box, in the coordinates of the unit cube, is above this, at any wavelength.
    pub fn majorant(&self, lo: DVec3, hi: DVec3) -> f64 {
        match self {
            Self::Constant(constant) => f64::from(constant.value.bound()),
            Self::Grid(grid) => grid.majorant(lo, hi),
        }
    }
}

/// The spectrum of a texture that does not vary, read from `element`.
fn constant(texture: AnyTexture, element: &Element) -> Result<SpectralFunction, SceneError> {
    match texture {
        AnyTexture::Constant(function) => Ok(function),
        _ => Err(SceneError::at(
            &element.span,
            "a texture has no value in space",
            "expected a colour, a spectrum or a <volume>",
        )),
    }
}
