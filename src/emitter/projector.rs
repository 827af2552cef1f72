//! Projectors.

use super::{AnyEmitter, DirectSample, Radiance, point};
use crate::math::cone::Cone;
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::sensor::{half_width, require_rigid};
use crate::spectrum::Wavelengths;
use crate::texture::AnyTexture;
use std::f64::consts::PI;

pub const NAME: &str = "projector";
pub const ABOUT: &str =
    "A pinhole camera the other way round: a point that throws a picture along its z axis.";
pub const EXAMPLES: &[&str] = &[
    r#"<emitter type="projector"><rgb name="irradiance" value="0.9, 0.5, 0.2"/><float name="scale" value="3"/></emitter>"#,
    r#"<emitter type="projector"><texture type="checkerboard" name="irradiance"/><float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0, 3, 0" target="0, 0, 0" up="0, 0, 1"/></transform></emitter>"#,
];

/// A plane at distance z along the axis, which faces the light, gets the irradiance πE(u, v)/z²: what looks
/// like a picture from the projector looks like that everywhere. So the intensity in a direction at an angle
/// θ to the axis is πE/cos³θ.
#[derive(Debug)]
pub struct Projector {
    /// E in W·m⁻²·nm⁻¹, over `scale`.
    picture: AnyTexture,
    scale: f64,
    to_world: Transform,
    /// Half the size of the picture at distance 1.
    half: DVec2,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let about = "the picture: what a white matte plane at distance 1 shows, over `scale`";
    let picture = params.texture("irradiance", 1.0, Usage::Emission, about)?;
    let scale = params.amount("scale", 1.0, "factor")?;
    let to_world = params.transform("to_world", "places it and turns +z where it shines")?;
    let aspect = picture.aspect();
    let half = half_width(params, aspect)?;
    require_rigid(params, &to_world, "a projector")?;
    let half = DVec2::new(half, half / aspect);
    Ok(AnyEmitter::Projector(Box::new(Projector { picture, scale, to_world, half })))
}

impl Projector {
    /// The light that falls on `p` (world); `None` outside of the picture.
    pub fn sample(&self, p: DVec3, λ: &Wavelengths) -> Option<DirectSample> {
        let (wi, distance, _) = point::arriving(p, self.place())?;
        let (uv, z) = self.seen(p)?;
        let cos = -wi.dot(self.axis());
        let radiance = Radiance::Known(self.picture.eval(uv, λ) * (PI * self.scale / (z * z * cos)) as f32);
        Some(DirectSample { wi, distance, radiance, pdf: 1.0, delta: true, n: DVec3::ZERO })
    }

    /// The place of the picture that falls on a point, as a camera sees that point on its film, and the
    /// point's distance along the axis; `None` beside the picture.
    fn seen(&self, p: DVec3) -> Option<(DVec2, f64)> {
        let local = self.to_world.inverse.transform_point3(p);
        let uv = 0.5 * (DVec2::ONE - local.truncate() / (local.z * self.half));
        let within = uv.min_element() >= 0.0 && uv.max_element() <= 1.0;
        (local.z > 0.0 && within).then_some((uv, local.z))
    }

    /// Its position (world).
    pub fn place(&self) -> DVec3 {
        self.to_world.point(DVec3::ZERO)
    }

    /// Where it shines (world, unit).
    fn axis(&self) -> DVec3 {
        unit(self.to_world.vector(DVec3::Z))
    }

    /// The axis, and the cosine of the angle to the corner of the picture that is farthest from it: where axes are not
    /// quite orthogonal corners differ. Everywhere if one is across.
    pub fn cone(&self) -> (Cone, f64) {
        const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;
        let (axis, DVec2 { x, y }) = (self.axis(), self.half);
        let corners = [(x, y), (x, -y), (-x, y), (-x, -y)];
        let cosines = corners.map(|(x, y)| axis.dot(unit(self.to_world.vector(DVec3::new(x, y, 1.0)))));
        let cos = cosines.into_iter().fold(1.0, f64::min) * (1.0 - ROUNDING);
        if cos > 0.0 { (Cone::along(axis), cos) } else { (Cone::EVERYWHERE, 0.0) }
    }

    /// Along its axis.
    pub fn intensity(&self) -> f64 {
        PI * self.scale * self.picture.mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;
    use crate::scene::Scene;
    use crate::sensor::Optics;
    use crate::spectrum::ColorMode;

    const PLACE: &str = r#"<float name="fov" value="50"/><string name="fov_axis" value="y"/>
        <transform name="to_world"><lookat origin="1, 2, 3" target="0, 0.5, 0" up="0.1, 1, 0"/></transform>"#;

    /// A camera and a projector of a square picture in the same place.
    fn scene(picture: &str) -> Scene {
        let text = format!(
            r#"<scene version="3.0.0"><sensor type="perspective">{PLACE}<film type="hdrfilm">
                <integer name="width" value="64"/><integer name="height" value="64"/></film></sensor>
            <emitter type="projector">{picture}{PLACE}</emitter></scene>"#
        );
        load_text("projector.xml", &text, ColorMode::Rgb).expect("it loads")
    }

    fn projector(scene: &Scene) -> &Projector {
        let AnyEmitter::Projector(projector) = &scene.emitters.list[0].emitter else { panic!("none") };
        projector
    }

    #[test]
    fn it_shines_where_a_camera_in_its_place_sees() {
        let scene = scene(r#"<rgb name="irradiance" value="0.5"/>"#);
        let projector = projector(&scene);
        let (mut within, mut beside) = (0, 0);
        for i in 0..1000 {
            let part = |step: u32| f64::from(i * step % 1000) / 250.0 - 2.0;
            let p = DVec3::new(part(1), part(37), part(411));
            let seen = scene.sensor.camera.connect(p, DVec2::ZERO).map(|view| view.film);
            let seen = seen.filter(|film| film.min_element() >= 0.0 && film.max_element() <= 1.0);
            match (projector.seen(p), seen) {
                (Some((uv, _)), Some(film)) => {
                    assert!((uv - film).abs().max_element() < 1e-12, "{p}: {uv}, {film}");
                    within += 1;
                }
                (None, None) => beside += 1,
                (uv, film) => panic!("{p}: {uv:?}, {film:?}"),
            }
        }
        assert!(within > 100 && beside > 100, "{within} {beside}");
    }

    /// Axes of unit length that are not orthogonal: the picture is a parallelogram, one corner of which is farther away.
    #[test]
    fn all_corners_are_within_the_cone() {
        for (z, sheared) in [("0.6", true), ("-0.6", true), ("0", false)] {
            let deep = if sheared { "0.8" } else { "1" };
            let text = format!(
                r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="projector"><transform name="to_world">
                    <matrix value="1 0 {z} 0  0 1 0 0  0 0 {deep} 0  0 0 0 1"/></transform></emitter></scene>"#
            );
            let scene = load_text("projector.xml", &text, ColorMode::Rgb).expect("it loads");
            let projector = projector(&scene);
            let (cone, cos) = projector.cone();
            let symmetric = 1.0 / (1.0 + projector.half.length_squared()).sqrt();
            let mut beyond = 0;
            for corner in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let inside = DVec3::new(corner.0 * projector.half.x, corner.1 * projector.half.y, 1.000_001);
                let towards = unit(projector.to_world.vector(inside));
                assert!(projector.seen(projector.place() + towards).is_some(), "{z}");
                assert!(towards.dot(projector.axis()) >= cos, "{z}");
                beyond += u32::from(towards.dot(projector.axis()) < 0.999 * symmetric);
            }
            assert!(cone == Cone::along(projector.axis()) && (beyond > 0) == sheared, "{z}: {beyond}");
        }
    }

    #[test]
    fn a_plane_across_the_axis_is_lit_evenly() {
        let scene = scene(r#"<rgb name="irradiance" value="0.5"/><float name="scale" value="6"/>"#);
        let projector = projector(&scene);
        for (x, y) in [(0.0, 0.0), (0.7, 0.2), (-0.8, -0.85)] {
            let p = projector.to_world.point(DVec3::new(x, y, 2.0));
            let light = projector.sample(p, &Wavelengths::rgb()).expect("it is lit");
            let Radiance::Known(radiance) = light.radiance else { panic!("a projector has no map") };
            let irradiance = f64::from(radiance.0[0]) * -light.wi.dot(projector.axis());
            assert!((irradiance / (PI * 3.0 / 4.0) - 1.0).abs() < 1e-6, "{x} {y}: {irradiance}");
        }
        let (cone, cos) = projector.cone();
        let corner = projector.to_world.vector(DVec3::new(projector.half.x, projector.half.y, 1.0));
        assert!(cone == Cone::along(projector.axis()) && unit(corner).dot(projector.axis()) >= cos);
    }
}
