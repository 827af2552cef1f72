//! Parallel light.

use super::{AnyEmitter, DirectSample, Radiance, require_constant};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::spectrum::Wavelengths;
use crate::texture::AnyTexture;

pub const NAME: &str = "directional";
pub const ABOUT: &str = "Parallel light from infinitely far away.";
pub const EXAMPLES: &[&str] =
    &[r#"<emitter type="directional"><vector name="direction" x="0" y="-1" z="0.2"/>
    <rgb name="irradiance" value="2"/></emitter>"#];

/// Light from one direction.
#[derive(Debug)]
pub struct Directional {
    /// Unit direction the light travels in.
    direction: DVec3,
    irradiance: AnyTexture,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let irradiance =
        params.texture("irradiance", 1.0, Usage::Emission, "on a plane facing the light, in W·m⁻²·nm⁻¹")?;
    require_constant(params, "irradiance", &irradiance, "expected a spectrum that is the same everywhere")?;
    let direction = params.direction("where the light goes", "turns +z to where the light goes")?;
    Ok(AnyEmitter::Directional(Directional { direction, irradiance }))
}

impl Directional {
    /// The light that falls on any point.
    pub fn sample(&self, λ: &Wavelengths) -> Option<DirectSample> {
        let radiance = Radiance::Known(self.irradiance.eval(DVec2::ZERO, λ));
        Some(DirectSample {
            wi: self.towards(),
            distance: f64::INFINITY,
            radiance,
            pdf: 1.0,
            delta: true,
            n: DVec3::ZERO,
        })
    }

    /// Against its direction.
    pub fn towards(&self) -> DVec3 {
        -self.direction
    }

    /// The irradiance in W·m⁻²·nm⁻¹ across its direction, the mean over the spectrum.
    pub fn irradiance(&self) -> f64 {
        self.irradiance.mean()
    }
}
