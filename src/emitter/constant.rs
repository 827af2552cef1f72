//! The same radiance from every direction.

use super::{AnyEmitter, DirectSample, OF_EVEN_LIGHT, Radiance, require_constant};
use crate::math::{DVec2, DVec3, Frame, INV_PI, warp};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;

pub const NAME: &str = "constant";
pub const ABOUT: &str = "A surrounding of the same radiance in all directions.";
pub const EXAMPLES: &[&str] = &[
    r#"<emitter type="constant"/>"#,
    r#"<emitter type="constant"><rgb name="radiance" value="0.3, 0.4, 0.6"/></emitter>"#,
];

/// Light of one radiance from all directions.
#[derive(Debug)]
pub struct Constant {
    radiance: AnyTexture,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let radiance = params.texture("radiance", 1.0, Usage::Emission, "radiance in W·m⁻²·sr⁻¹·nm⁻¹")?;
    params.transform("to_world", "ignored: it looks the same from all sides")?;
    require_constant(params, "radiance", &radiance, "expected a colour; see `envmap`")?;
    Ok(AnyEmitter::Constant(Constant { radiance }))
}

impl Constant {
    /// A direction of the hemisphere about `n` by the cosine, or of the sphere if `n` is zero.
    pub fn sample(&self, n: DVec3, u: DVec2, λ: &Wavelengths) -> Option<DirectSample> {
        let wi = if n == DVec3::ZERO {
            warp::sphere(u)
        } else {
            Frame::about(n).to_world(warp::cosine_hemisphere(u))
        };
        let (radiance, pdf) = (Radiance::Known(self.radiance(λ)), Self::pdf(wi, n));
        let n = DVec3::ZERO;
        (pdf > 0.0).then_some(DirectSample { wi, distance: f64::INFINITY, radiance, pdf, delta: false, n })
    }

    /// The radiance in W·m⁻²·sr⁻¹·nm⁻¹ from any direction.
    pub fn radiance(&self, λ: &Wavelengths) -> Spectrum {
        self.radiance.eval(DVec2::ZERO, λ)
    }

    /// The density of a direction ω (unit, world), in sr⁻¹.
    pub fn pdf(w: DVec3, n: DVec3) -> f64 {
        if n == DVec3::ZERO { 0.25 * INV_PI } else { INV_PI * n.dot(w).max(0.0) }
    }

    /// The part of its radiance that is sought by emitter samples.
    pub fn sought(&self) -> f64 {
        OF_EVEN_LIGHT * self.radiance.mean()
    }
}
