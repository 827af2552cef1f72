//! Spot lights.

use super::{AnyEmitter, DirectSample, Radiance, point, require_constant};
use crate::math::cone::Cone;
use crate::math::frame::unit;
use crate::math::function::{atan2, cos, tan};
use crate::math::{DVec2, DVec3, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::spectrum::Wavelengths;
use crate::texture::AnyTexture;

pub const NAME: &str = "spot";
pub const ABOUT: &str = "A point that shines into a cone about its z axis, fading between two angles.";
pub const EXAMPLES: &[&str] = &[r#"<emitter type="spot"><rgb name="intensity" value="10"/>
    <float name="cutoff_angle" value="30"/><float name="beam_width" value="20"/></emitter>"#];

/// Light from a point, within a cone.
#[derive(Debug)]
pub struct Spot {
    intensity: AnyTexture,
    /// An image that the light projects.
    texture: Option<AnyTexture>,
    to_world: Transform,
    /// Angle to the axis beyond which no light leaves, in radians.
    cutoff: f64,
    beam: f64,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let intensity =
        params.texture("intensity", 1.0, Usage::Emission, "intensity on the axis in W·sr⁻¹·nm⁻¹")?;
    require_constant(params, "intensity", &intensity, "expected a spectrum that is the same everywhere")?;
    let texture = params.optional_texture("texture", Usage::Unbounded, "an image to project")?;
    let to_world = params.transform("to_world", "places it and turns +z where it shines")?;
    let expected = "degrees above 0 and below 90";
    let in_range = |v: f64| v > 0.0 && v < 90.0;
    let cutoff = params.float_where("cutoff_angle", 20.0, "no light beyond, degrees", expected, in_range)?;
    let about = "full light within, degrees; what is beyond `cutoff_angle` is cut off";
    let beam = params
        .float_where("beam_width", 0.75 * cutoff, about, "0 to 90 degrees", |v| (0.0..=90.0).contains(&v))?;
    let (cutoff, beam) = (cutoff.to_radians(), beam.min(cutoff).to_radians());
    Ok(AnyEmitter::Spot(Box::new(Spot { intensity, texture, to_world, cutoff, beam })))
}

impl Spot {
    /// The light that falls on `p` (world); `None` outside of the cone.
    pub fn sample(&self, p: DVec3, λ: &Wavelengths) -> Option<DirectSample> {
        let (wi, distance, falloff) = point::arriving(p, self.place())?;
        let local = unit(self.to_world.inverted().vector(-wi));
        // By the sine too: a cosine does not tell small angles.
        let angle = atan2((local.x * local.x + local.y * local.y).sqrt(), local.z);
        if angle >= self.cutoff {
            return None;
        }
        let fade = if angle <= self.beam { 1.0 } else { (self.cutoff - angle) / (self.cutoff - self.beam) };
        let mut radiance = self.intensity.eval(DVec2::ZERO, λ) * (falloff * fade as f32);
        if let Some(texture) = &self.texture {
            let scale = 0.5 / (local.z * tan(self.cutoff));
            radiance *= texture.eval(DVec2::new(0.5 + local.x * scale, 0.5 + local.y * scale), λ);
        }
        let radiance = Radiance::Known(radiance);
        Some(DirectSample { wi, distance, radiance, pdf: 1.0, delta: true, n: DVec3::ZERO })
    }

    /// Its position (world).
    pub fn place(&self) -> DVec3 {
        self.to_world.point(DVec3::ZERO)
    }

    /// The axis and the cosine beyond which no light goes; everywhere if a transform has made the cone no
    /// longer round.
    pub fn cone(&self) -> (Cone, f64) {
        const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;
        let axes = DVec3::AXES.map(|axis| self.to_world.vector(axis));
        let alike = |a: f64, b: f64| (a - b).abs() <= ROUNDING * b;
        let round = (0..3).all(|i| {
            let (a, b) = (axes[i], axes[(i + 1) % 3]);
            alike(a.length_squared(), b.length_squared()) && a.dot(b).abs() <= ROUNDING * b.length_squared()
        });
        if round {
            (Cone::along(unit(axes[2])), cos(self.cutoff) * (1.0 - ROUNDING))
        } else {
            (Cone::EVERYWHERE, 0.0)
        }
    }

    /// Along its axis, or the mean of its texture.
    pub fn intensity(&self) -> f64 {
        self.intensity.mean() * self.texture.as_ref().map_or(1.0, AnyTexture::mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;
    use crate::spectrum::ColorMode;

    /// What arrives at places one away from a spot at the origin that shines along z, by the angle from the axis.
    fn arriving(cutoff: f64, beam_width: f64, degrees: f64) -> Option<f32> {
        let text = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="spot"><rgb name="intensity" value="3"/>
                <float name="cutoff_angle" value="{cutoff}"/><float name="beam_width" value="{beam_width}"/></emitter></scene>"#
        );
        let scene = load_text("spot.xml", &text, ColorMode::Rgb).unwrap();
        let AnyEmitter::Spot(spot) = &scene.emitters.list[0].emitter else { panic!("no spot") };
        let (sin, cos) = degrees.to_radians().sin_cos();
        let found = spot.sample(DVec3::new(0.6 * sin, 0.8 * sin, cos), &Wavelengths::rgb());
        found.map(|light| match light.radiance {
            Radiance::Known(radiance) => radiance.0[0],
            Radiance::Mapped(_) => panic!("a spot has no map"),
        })
    }

    /// Asks what arrives with a cutoff, a beam and an angle from the axis, in degrees.
    fn arrives(cutoff: f64, beam_width: f64, degrees: f64, expected: Option<f32>) {
        let found = arriving(cutoff, beam_width, degrees);
        let alike = match (found, expected) {
            (Some(found), Some(expected)) => (found - expected).abs() < 1e-6 * expected,
            (found, expected) => found == expected,
        };
        assert!(alike, "cutoff {cutoff}, beam {beam_width}, {degrees} degrees: {found:?}");
    }

    #[test]
    fn light_fades_from_the_beam_to_the_cutoff_and_a_wider_beam_is_cut_off() {
        for (beam_width, degrees, expected) in [
            (10.0, 9.0, Some(3.0)),
            (10.0, 15.0, Some(1.5)),
            (10.0, 21.0, None),
            (20.0, 19.0, Some(3.0)),
            (30.0, 19.0, Some(3.0)),
            (30.0, 21.0, None),
        ] {
            arrives(20.0, beam_width, degrees, expected);
        }
    }

    /// Half way into the rim of a cone of a millionth of a degree there is half of the light.
    #[test]
    fn narrow_cones_have_their_rim() {
        for (share, expected) in [(0.0, Some(3.0)), (0.5, Some(1.5)), (0.75, Some(0.75)), (1.001, None)] {
            arrives(1e-6, 0.0, share * 1e-6, expected);
        }
    }
}
