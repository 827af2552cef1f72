//! Roughness as scene files give it: one texture or two, and which distribution of facets they are of.

use super::microfacet::{Distribution, Shape};
use crate::math::DVec2;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::texture::AnyTexture;

/// A roughness below which lobes are narrow: half of what such a metal reflects goes into a cone of 30°.
pub const NARROW: f64 = 0.25;

/// Roughness as scene files give it.
pub struct Roughness {
    shape: Shape,
    alpha_u: AnyTexture,
    /// Absent where both directions are alike.
    alpha_v: Option<AnyTexture>,
    visible: bool,
}

impl Roughness {
    /// Reads `distribution`, `alpha` or `alpha_u` and `alpha_v`, and `sample_visible`.
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let (shape, visible) = parse_shape(params)?;
        has_two_roughnesses(params)?;
        let both = params.texture(
            "alpha",
            0.1,
            Usage::Unbounded,
            "roughness: √2 times the deviation of the slope",
        )?;
        let u = params.optional_texture("alpha_u", Usage::Unbounded, "roughness along the tangent")?;
        let v = params.optional_texture("alpha_v", Usage::Unbounded, "roughness across the tangent")?;
        let (both, u, v) = (both.scalar(), u.map(AnyTexture::scalar), v.map(AnyTexture::scalar));
        Ok(Self { shape, alpha_u: u.unwrap_or(both), alpha_v: v, visible })
    }

    /// Whether lobes are narrow in a direction, by the mean of what varies over the surface.
    pub fn narrow(&self) -> bool {
        [Some(&self.alpha_u), self.alpha_v.as_ref()].into_iter().flatten().any(|alpha| alpha.mean() < NARROW)
    }

    #[inline]
    pub fn at(&self, uv: DVec2) -> Distribution {
        let alpha_u = self.alpha_u.eval_scalar(uv);
        let alpha_v = self.alpha_v.as_ref().map_or(alpha_u, |texture| texture.eval_scalar(uv));
        Distribution::new(self.shape, alpha_u, alpha_v).sampling_visible(self.visible)
    }

    pub fn anisotropic(&self) -> bool {
        self.alpha_v.is_some()
    }

    pub fn varies(&self) -> bool {
        self.alpha_u.varies() || self.alpha_v.as_ref().is_some_and(AnyTexture::varies)
    }
}

/// Whether a file gives `alpha_u` and `alpha_v` instead of `alpha`. Errors: one of them alone, or beside it.
pub fn has_two_roughnesses(params: &Params) -> Result<bool, SceneError> {
    let (given, missing) = match ["alpha_u", "alpha_v"].map(|name| params.has(name)) {
        [false, false] => return Ok(false),
        _ if params.has("alpha") => {
            let message = "`alpha` beside `alpha_u` or `alpha_v`";
            return Err(params.error("alpha", message, "expected one roughness or two"));
        }
        [true, true] => return Ok(true),
        [true, false] => ("alpha_u", "alpha_v"),
        [false, true] => ("alpha_v", "alpha_u"),
    };
    Err(params.error(given, format!("`{given}` without `{missing}`"), "expected both"))
}

/// Reads `distribution` and `sample_visible`.
pub fn parse_shape(params: &mut Params) -> Result<(Shape, bool), SceneError> {
    let about = "how the facets' slopes are distributed: beckmann or ggx";
    let shape = match params.word("distribution", &["beckmann", "ggx"], about)? {
        "ggx" => Shape::Ggx,
        _ => Shape::Beckmann,
    };
    let about = "sample only facets that the viewer sees; changes the noise, not the image";
    Ok((shape, params.boolean("sample_visible", true, about)?))
}
