//! The same light from everywhere.

use super::{AnyEmitter, DirectSample};
use crate::math::{DVec2, DVec3, INV_PI, warp};
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

#[derive(Debug)]
pub struct Constant {
    radiance: AnyTexture,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let radiance = params.texture("radiance", 1.0, Usage::Emission, "radiance in W·m⁻²·sr⁻¹·nm⁻¹")?;
    if radiance.varies() {
        return Err(params.error(
            "radiance",
            "a constant emitter cannot be textured",
            "expected a colour; see `envmap`",
        ));
    }
    Ok(AnyEmitter::Constant(Constant { radiance }))
}

impl Constant {
    const PDF: f64 = 0.25 * INV_PI;

    pub fn sample(&self, u: DVec2, λ: &Wavelengths) -> DirectSample {
        let radiance = self.radiance.eval(DVec2::ZERO, λ);
        DirectSample {
            wi: warp::sphere(u),
            distance: f64::INFINITY,
            radiance,
            pdf: Self::PDF,
            delta: false,
            n: DVec3::ZERO,
        }
    }

    pub fn radiance(&self, λ: &Wavelengths) -> (Spectrum, f64) {
        (self.radiance.eval(DVec2::ZERO, λ), Self::PDF)
    }

    pub fn mean(&self) -> f64 {
        self.radiance.mean()
    }
}
