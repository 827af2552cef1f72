//! Two textures in alternating squares.

use super::{AnyTexture, Placement};
use crate::math::DVec2;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};

pub const NAME: &str = "checkerboard";
pub const ABOUT: &str = "Two textures in alternating squares, two by two in the unit square of uv.";
pub const EXAMPLES: &[&str] = &[
    r#"<texture type="checkerboard"/>"#,
    r#"<texture type="checkerboard"><rgb name="color0" value="0.9, 0.1, 0.1"/><rgb name="color1" value="0.1, 0.1, 0.9"/>
        <transform name="to_uv"><scale x="4" y="4"/></transform></texture>"#,
];

/// Squares of two textures in turn.
#[derive(Clone, Debug)]
pub struct Checkerboard {
    sides: [AnyTexture; 2],
    placement: Placement,
}

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    // Squares of a light are reflectances, as texels of a bitmap are; numbers stay numbers.
    let usage = if params.usage == Usage::Emission { Usage::Reflectance } else { params.usage };
    let first = params.texture("color0", 0.4, usage, "colour of the squares at the origin")?;
    let second = params.texture("color1", 0.2, usage, "colour of the others")?;
    let placement = Placement::parse(params)?;
    Ok(AnyTexture::Checkerboard(Box::new(Checkerboard { sides: [first, second], placement })))
}

impl Checkerboard {
    /// The texture at a place.
    #[inline]
    pub fn side(&self, uv: DVec2) -> &AnyTexture {
        let p = self.placement.point(uv);
        let half = |x: f64| x - x.floor() > 0.5;
        &self.sides[usize::from(half(p.x) != half(p.y))]
    }

    /// The texture at a place, if the board is used as a number. Mitsuba 3.9.1 exchanges the squares then,
    /// and the same file must mean the same.
    #[inline]
    pub fn scalar_side(&self, uv: DVec2) -> &AnyTexture {
        let first = std::ptr::eq(self.side(uv), &self.sides[0]);
        &self.sides[usize::from(first)]
    }

    /// See [`AnyTexture::bound`].
    pub fn bound(&self) -> f32 {
        self.sides[0].bound().max(self.sides[1].bound())
    }

    /// The mean over the texture and the spectrum.
    pub fn mean(&self) -> f64 {
        0.5 * (self.sides[0].mean() + self.sides[1].mean())
    }
}
