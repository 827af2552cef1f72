//! A point light.

use super::{AnyEmitter, DirectSample, Radiance, require_constant};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::spectrum::Wavelengths;
use crate::texture::AnyTexture;

pub const NAME: &str = "point";
pub const ABOUT: &str = "A point that shines equally into all directions.";
pub const EXAMPLES: &[&str] = &[r#"<emitter type="point"><point name="position" x="0" y="5" z="0"/>
    <rgb name="intensity" value="10"/></emitter>"#];

/// Light from a point, equal in all directions.
#[derive(Debug)]
pub struct Point {
    position: DVec3,
    intensity: AnyTexture,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let intensity = params.texture("intensity", 1.0, Usage::Emission, "radiant intensity in W·sr⁻¹·nm⁻¹")?;
    require_constant(params, "intensity", &intensity, "expected a spectrum that is the same everywhere")?;
    if params.has("position") && params.has("to_world") {
        return Err(params.error("to_world", "both `position` and `to_world`", "expected one of them"));
    }
    let position = params.vector("position", None, "where it is")?;
    let to_world = params.transform("to_world", "places it instead of `position`")?;
    Ok(AnyEmitter::Point(Point {
        position: position.unwrap_or_else(|| to_world.point(DVec3::ZERO)),
        intensity,
    }))
}

/// Direction, distance and 1/d² from `p` to a point light; nothing in the light itself.
pub fn arriving(p: DVec3, position: DVec3) -> Option<(DVec3, f64, f32)> {
    let towards = position - p;
    let d2 = towards.length_squared();
    (d2 > 0.0).then(|| (towards / d2.sqrt(), d2.sqrt(), (1.0 / d2) as f32))
}

impl Point {
    /// The light that falls on `p` (world); `None` at the emitter itself.
    pub fn sample(&self, p: DVec3, λ: &Wavelengths) -> Option<DirectSample> {
        let (wi, distance, falloff) = arriving(p, self.position)?;
        let radiance = Radiance::Known(self.intensity.eval(DVec2::ZERO, λ) * falloff);
        Some(DirectSample { wi, distance, radiance, pdf: 1.0, delta: true, n: DVec3::ZERO })
    }

    /// Its position (world).
    pub fn place(&self) -> DVec3 {
        self.position
    }

    /// The radiant intensity in W·sr⁻¹·nm⁻¹, the mean over the spectrum.
    pub fn intensity(&self) -> f64 {
        self.intensity.mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_falls_off_with_the_square_of_the_distance_and_does_not_reach_itself() {
        let place = DVec3::new(0.1, 0.2, 0.3);
        let (towards, distance, falloff) = arriving(place - DVec3::Z * 4.0, place).unwrap();
        assert!((towards - DVec3::Z).abs().max_element() < 1e-15 && (distance - 4.0).abs() < 1e-15);
        assert_eq!(falloff, 0.0625);
        assert!(arriving(place, place).is_none());
    }
}
