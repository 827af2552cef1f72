//! Values that may vary over a surface. Each file of this folder is a model; the constant spectra are models
//! too, because a scene file may give either wherever it gives a colour.
//!
//! *How to add one*: write `texture/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`, and add its line
//! to `textures!`. One that varies over a surface in a new way also is a variant of [`AnyTexture`], whose methods the
//! compiler then asks for, each with what it answers. Textures within it are read with the `usage` it is read with
//! itself. `contract.rs` tests all examples.

pub mod bitmap;
mod blackbody;
mod checkerboard;
mod color;
#[cfg(test)]
mod contract;
mod d65;
mod irregular;
mod lookup;
pub mod mesh_attribute;
mod placement;
mod rawconstant;
mod regular;
mod srgb;
mod uniform;

use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::Usage;
use crate::scene::registry::{Entry, construct};
use crate::scene::xml::Element;
use crate::spectrum::{ColorMode, SpectralFunction, Spectrum, Wavelengths};
pub use bitmap::Bitmap;
pub use checkerboard::Checkerboard;
pub use color::scaled as color_scale;
pub use d65::UnderD65;
pub use lookup::Lookup;
pub use mesh_attribute::MeshAttribute;
pub use placement::Placement;

/// Any texture.
#[derive(Clone, Debug)]
pub enum AnyTexture {
    Constant(SpectralFunction),
    Bitmap(Box<Bitmap>),
    Checkerboard(Box<Checkerboard>),
    UnderD65(Box<UnderD65>),
    MeshAttribute(Box<MeshAttribute>),
}

macro_rules! textures {
    ($($module:ident),* $(,)?) => {
        /// Every texture and constant spectrum.
        pub static TEXTURES: &[Entry<AnyTexture>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: $module::parse,
        }),*];
    };
}
textures!(
    bitmap,
    checkerboard,
    mesh_attribute,
    uniform,
    regular,
    irregular,
    rawconstant,
    srgb,
    d65,
    blackbody
);

impl AnyTexture {
    /// Reads `<rgb>`, `<spectrum>`, `<float>` or `<texture>`.
    pub fn parse<'d>(element: &'d Element, loader: &Loader<'d>, usage: Usage) -> Result<Self, SceneError> {
        let texture = if Self::is_object(element) {
            construct(TEXTURES, element, loader, usage)?
        } else {
            Self::Constant(color::parse(element, loader, usage)?)
        };
        let most = texture.bound();
        if usage == Usage::Reflectance && most > 1.0 {
            let message = format!("values up to {most} are no reflectance");
            return Err(SceneError::at(&element.span, message, "expected 0 to 1"));
        }
        Ok(texture)
    }

    /// Whether an element is an object of its own, not just a value.
    pub fn is_object(element: &Element) -> bool {
        element.tag == "texture" || element.tag == "spectrum" && element.attribute("type").is_some()
    }

    /// The constant that is used where a file gives nothing.
    pub fn default_value(value: f64, usage: Usage, mode: ColorMode) -> Self {
        let constant = SpectralFunction::Uniform(value as f32);
        match (usage, mode) {
            (Usage::Emission, ColorMode::Spectral) => Self::Constant(color::white_illuminant(value)),
            _ => Self::Constant(constant),
        }
    }

    /// The value in each lane at texture coordinates `uv`: a reflectance, or a weight, without unit.
    #[inline]
    pub fn eval(&self, uv: DVec2, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Constant(function) => function.eval(λ),
            _ => self.eval_at(uv, λ),
        }
    }

    /// [`AnyTexture::eval`] for emission.
    #[inline]
    pub fn eval_light(&self, uv: DVec2, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Constant(function) => function.eval_light(λ),
            _ => self.eval_at(uv, λ),
        }
    }

    /// [`AnyTexture::eval`] of what varies, out of the way of scenes where nothing does.
    #[inline(never)]
    fn eval_at(&self, uv: DVec2, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Constant(function) => function.eval(λ),
            Self::Bitmap(bitmap) => bitmap.eval(uv, λ),
            Self::Checkerboard(board) => board.side(uv).eval(uv, λ),
            Self::UnderD65(product) => product.eval(uv, λ),
            Self::MeshAttribute(attribute) => attribute.eval(uv, λ),
        }
    }

    /// The value of a texture that holds numbers, not colours: roughness, opacity, blend weights.
    #[inline]
    pub fn eval_scalar(&self, uv: DVec2) -> f64 {
        match self {
            Self::Constant(function) => {
                function.constant().map_or_else(|| function.visible_mean(), f64::from)
            }
            Self::Bitmap(bitmap) => bitmap.eval_scalar(uv),
            Self::Checkerboard(board) => board.scalar_side(uv).eval_scalar(uv),
            Self::UnderD65(product) => product.eval_scalar(uv),
            Self::MeshAttribute(attribute) => attribute.eval_scalar(uv),
        }
    }

    /// A texture for [`AnyTexture::eval_scalar`] alone: the mean of a colour is taken once, not at every
    /// call.
    pub fn scalar(self) -> Self {
        match self {
            Self::Constant(function) if function.constant().is_none() => {
                Self::Constant(SpectralFunction::Uniform(function.visible_mean() as f32))
            }
            other => other,
        }
    }

    /// The three numbers of a texture that was read with [`Usage::Vector`]; `None` if it has not three.
    #[inline]
    pub fn eval_vector(&self, uv: DVec2) -> Option<DVec3> {
        match self {
            Self::Constant(SpectralFunction::Rgb(v)) => Some(DVec3::from(v.map(f64::from))),
            Self::Constant(function) => function.constant().map(|v| DVec3::splat(v as f64)),
            Self::Bitmap(bitmap) => bitmap.eval_vector(uv),
            Self::MeshAttribute(attribute) => attribute.eval_vector(uv),
            Self::Checkerboard(_) | Self::UnderD65(_) => None,
        }
    }

    /// (∂/∂u, ∂/∂v) of [`AnyTexture::eval_scalar`]; `None` if the texture is discontinuous or no number.
    #[inline]
    pub fn gradient(&self, uv: DVec2) -> Option<DVec2> {
        match self {
            Self::Constant(_) => Some(DVec2::ZERO),
            Self::Bitmap(bitmap) => Some(bitmap.gradient(uv)),
            Self::Checkerboard(_) | Self::UnderD65(_) | Self::MeshAttribute(_) => None,
        }
    }

    /// The mean over the surface and the spectrum, of pictures that of the luminance: a weight for choosing between
    /// lobes and lights.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Constant(function) => function.mean(),
            Self::Bitmap(bitmap) => bitmap.mean(),
            Self::Checkerboard(board) => board.mean(),
            Self::UnderD65(product) => product.mean(),
            Self::MeshAttribute(attribute) => attribute.mean(),
        }
    }

    /// No value is above this, at any wavelength or in any channel; of textures that are read as reflectances 1.
    pub fn bound(&self) -> f32 {
        match self {
            Self::Constant(function) => function.bound(),
            Self::UnderD65(product) => product.bound(),
            Self::Checkerboard(board) => board.bound(),
            // Looked at texel by texel, and vertex by vertex.
            Self::Bitmap(_) | Self::MeshAttribute(_) => 1.0,
        }
    }

    /// Luminance of a colour relative to white, under D65.
    pub fn luminance(&self, uv: DVec2) -> f64 {
        match self {
            Self::Constant(function) => function.luminance(),
            Self::Checkerboard(board) => board.side(uv).luminance(uv),
            Self::UnderD65(product) => product.luminance(uv),
            // They keep it as their number.
            Self::Bitmap(_) | Self::MeshAttribute(_) => self.eval_scalar(uv),
        }
    }

    /// The value of this texture, if it is one number everywhere and at every wavelength.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(function) => function.constant().map(|v| v as f64),
            _ => None,
        }
    }

    /// Width over height of the picture; 1 of what is no picture.
    pub fn aspect(&self) -> f64 {
        match self {
            Self::Bitmap(bitmap) => bitmap.aspect(),
            Self::UnderD65(product) => product.aspect(),
            Self::Constant(_) | Self::Checkerboard(_) | Self::MeshAttribute(_) => 1.0,
        }
    }

    /// Whether the value depends on the place.
    pub fn varies(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::UnderD65(product) => product.varies(),
            Self::Bitmap(_) | Self::Checkerboard(_) | Self::MeshAttribute(_) => true,
        }
    }
}
