//! Numbers and colours that a mesh file has for its vertices or faces.

use super::AnyTexture;
use crate::math::{DVec2, DVec3};
use crate::scene::error::{SceneError, known};
use crate::scene::params::{Params, Usage};
use crate::scene::xml::Attribute as Text;
use crate::shape::Chart;
use crate::shape::mesh_data::{Answer, Attribute};
use crate::spectrum::upsample::{Sigmoid, Upsampler};
use crate::spectrum::{Spectrum, Wavelengths, observer};
use rayon::prelude::*;
use std::sync::Arc;

pub const NAME: &str = "mesh_attribute";
pub const ABOUT: &str =
    "An attribute of the vertices or faces of the `ply` mesh that it is on, such as `vertex_color`.";
pub const EXAMPLES: &[&str] = &[];

/// The values of vertices or triangles.
#[derive(Debug)]
enum Values {
    /// One number for all wavelengths.
    Numbers,
    /// Linear sRGB, or three numbers.
    Rgb(Vec<[f32; 3]>),
    /// Factors upon reflectance spectra, and these.
    Reflectance(Vec<(f32, Sigmoid)>),
}

/// An attribute of a mesh.
#[derive(Clone, Debug)]
pub struct MeshAttribute {
    chart: Arc<Chart>,
    values: Arc<Values>,
    /// The numbers, or the luminances of colours.
    scalar: Arc<[f32]>,
    of_faces: bool,
}

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let name = params.string("name", "begins with `vertex_` or `face_`")?;
    let scale = params.amount("scale", 1.0, "factor upon the values")? as f32;
    let name = name.ok_or_else(|| {
        params.error("name", "a mesh attribute needs a `name`", "expected one such as `vertex_color`")
    })?;
    let chart = params.loader.chart().ok_or_else(|| {
        let message = "there is no mesh here that has attributes";
        SceneError::at(&params.element.span, message, "expected it in a material or lamp of a `ply`")
    })?;
    let answer = ask(&chart, name)?;
    let attribute = found(&chart, name, &answer)?;
    check_range(attribute, scale, name, params.usage)?;
    let numbers = params.usage.is_numbers(params.loader.mode);
    let (values, scalar) = match attribute.values.as_chunks().0 {
        triples if attribute.width == 3 => {
            let luminance = |rgb: &[f32; 3]| observer::luminance(rgb.map(f64::from)) as f32 * scale;
            let scalar = triples.iter().map(luminance).collect();
            let values = if numbers {
                Values::Rgb(triples.iter().map(|rgb| rgb.map(|value| value * scale)).collect())
            } else {
                Values::reflectances(triples, scale, &params.loader.upsampler)
            };
            (values, scalar)
        }
        _ => (Values::Numbers, attribute.values.iter().map(|value| value * scale).collect()),
    };
    let (values, of_faces) = (Arc::new(values), attribute.of_faces);
    Ok(AnyTexture::MeshAttribute(Box::new(MeshAttribute { chart, values, scalar, of_faces })))
}

fn ask(chart: &Chart, name: &Text) -> Result<Arc<Answer>, SceneError> {
    chart.attribute(&name.value).map_err(|damage| {
        let message = format!("{}: {damage}", chart.file.path.display());
        SceneError::at(&name.value_span, message, "expected a whole mesh")
    })
}

/// The attribute that a mesh's file was asked for.
fn found<'a>(chart: &Chart, name: &Text, answer: &'a Answer) -> Result<&'a Attribute, SceneError> {
    let path = chart.file.path.display();
    match answer {
        Answer::Found(attribute) => {
            let (vertices, triangles) = chart.counts();
            let count = attribute.values.len() / attribute.width;
            if count < if attribute.of_faces { triangles } else { vertices } {
                let message = format!("{path} has changed while it was read");
                return Err(SceneError::at(&name.value_span, message, "expected the same file"));
            }
            Ok(attribute)
        }
        Answer::Others(others) => {
            let message = format!("{path} has no attribute `{}`", name.value);
            let others: Vec<&str> = others.iter().map(String::as_str).collect();
            let help = match others[..] {
                [] => "it has none at all".into(),
                _ => known(&name.value, &others),
            };
            Err(SceneError::at(&name.value_span, message, help))
        }
    }
}

fn check_range(attribute: &Attribute, scale: f32, name: &Text, usage: Usage) -> Result<(), SceneError> {
    let (allowed, expected) = usage.allowed();
    let strange = attribute.values.iter().position(|value| !allowed.contains(&(value * scale)));
    let Some(index) = strange else { return Ok(()) };
    let (number, value) = (index / attribute.width, attribute.values[index] * scale);
    let part = if attribute.of_faces { "triangle" } else { "vertex" };
    let message = format!("`{}` of {part} {number} is {value}", name.value);
    Err(SceneError::at(&name.value_span, message, expected))
}

impl Values {
    /// The spectra of colours times a scale: as in Mitsuba, those of the colours, scaled; but where that is by more than 1,
    /// so that spectra could exceed what the colours do, or where some of the colours are beyond 1, which have none, those
    /// of the scaled ones, and beyond 1 in proportion.
    fn reflectances(colours: &[[f32; 3]], scale: f32, upsampler: &Upsampler) -> Self {
        let beyond = scale > 1.0 || colours.as_flattened().iter().any(|value| *value > 1.0);
        let fit = |rgb: &[f32; 3]| match beyond {
            false => (scale, upsampler.fit(*rgb)),
            true => upsampler.fit_in_proportion(rgb.map(|value| f64::from(value * scale))),
        };
        Self::Reflectance(colours.par_iter().map(fit).collect())
    }
}

impl MeshAttribute {
    /// The items that the value at a place is a mean of, with their weights.
    #[inline]
    fn parts(&self, uv: DVec2) -> [(usize, f32); 3] {
        let place = self.chart.place(uv);
        if self.of_faces {
            return [(place.triangle as usize, 1.0), (0, 0.0), (0, 0.0)];
        }
        let weights = place.weights();
        [0, 1, 2].map(|i| (place.corners[i] as usize, weights[i] as f32))
    }

    /// The value in each lane at a place.
    pub fn eval(&self, uv: DVec2, λ: &Wavelengths) -> Spectrum {
        match &*self.values {
            Values::Numbers => Spectrum::splat(self.eval_scalar(uv) as f32),
            Values::Rgb(values) => {
                let [r, g, b] = interpolated(&self.parts(uv), values);
                Spectrum([r, g, b, 0.0, 0.0, 0.0, 0.0, 0.0])
            }
            Values::Reflectance(values) => {
                let mut sum = Spectrum::ZERO;
                for (i, weight) in self.parts(uv) {
                    let (factor, colour) = &values[i];
                    sum += Spectrum(colour.eval_lanes(&λ.nm)) * (factor * weight);
                }
                sum
            }
        }
    }

    /// The value at a place where one number is asked for: the luminance of colours.
    pub fn eval_scalar(&self, uv: DVec2) -> f64 {
        self.parts(uv).into_iter().map(|(i, weight)| f64::from(self.scalar[i] * weight)).sum()
    }

    /// Three numbers; `None` of one, and of spectra.
    pub fn eval_vector(&self, uv: DVec2) -> Option<DVec3> {
        let Values::Rgb(values) = &*self.values else { return None };
        Some(DVec3::from(interpolated(&self.parts(uv), values).map(f64::from)))
    }

    /// The mean over the surface of what [`eval_scalar`](Self::eval_scalar) is there.
    pub fn mean(&self) -> f64 {
        let scalar = |i: usize| f64::from(self.scalar[i]);
        self.chart.mean(|triangle, corners| match self.of_faces {
            true => scalar(triangle),
            false => corners.map(|i| scalar(i as usize)).iter().sum::<f64>() / 3.0,
        })
    }
}

fn interpolated(parts: &[(usize, f32); 3], values: &[[f32; 3]]) -> [f32; 3] {
    [0, 1, 2].map(|c| parts.iter().map(|(i, weight)| values[*i][c] * weight).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Bsdf;
    use crate::load_text;
    use crate::math::Ray;
    use crate::scene::{Features, Scene};
    use crate::spectrum::ColorMode;
    use std::fs;

    const MESH: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float u\nproperty float v\nproperty float r\nproperty float g\nproperty float b\n\
        property float heat_x\nelement face 2\nproperty list uchar int vertex_indices\nproperty float age_x\nend_header\n\
        0 0 0 0 0 0.1 0.2 0.3 0\n1 0 0 0.2 0 0.9 0.1 0.1 1\n1 1 0 0.2 0.8 0.4 0.4 0.4 0.5\n0 1 0 0 0.8 0.2 0.8 0.2 0.25\n\
        3 0 1 2 0.75\n3 0 2 3 0.5\n";

    fn load(mesh: &str, on_mesh: &str, elsewhere: &str, mode: ColorMode) -> Result<Scene, SceneError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        fs::write(&path, mesh).unwrap();
        let text = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="ply"><string name="filename" value="{}"/>
            {on_mesh}</shape>{elsewhere}</scene>"#,
            path.display()
        );
        load_text("scene.xml", &text, mode)
    }

    fn matte(name: &str) -> String {
        format!(
            r#"<bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance"><string name="name" value="{name}"/>
            </texture></bsdf>"#
        )
    }

    /// What a matte mesh reflects at a place of its square, at these wavelengths or in the channels.
    fn reflected(scene: &Scene, (x, y): (f64, f64), λ: &Wavelengths) -> [f32; 3] {
        let ray = Ray::free(DVec3::new(x, y, 1.0), -DVec3::Z);
        let hit = scene.accel.closest(&ray).unwrap();
        let (shape, point) = scene.surface::<{ Features::ALL }>(&ray, &hit);
        let albedo = scene.materials[shape.sides[0].material as usize].at(&point, λ).albedo().unwrap();
        [0, 1, 2].map(|i| albedo.0[i])
    }

    fn assert_near(a: [f32; 3], b: [f32; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
    }

    #[test]
    fn vertices_are_interpolated_and_faces_are_not() {
        let λ = Wavelengths::rgb();
        let scene = load(MESH, &matte("vertex_color"), "", ColorMode::Rgb).unwrap();
        // ¼, ½ and ¼ of the first triangle's corners; ½ of the first and a quarter of the others in the second.
        assert_near(reflected(&scene, (0.75, 0.25), &λ), [0.575, 0.2, 0.225]);
        assert_near(reflected(&scene, (0.25, 0.5), &λ), [0.2, 0.4, 0.3]);
        let scene = load(MESH, &matte("vertex_heat"), "", ColorMode::Rgb).unwrap();
        assert_near(reflected(&scene, (0.75, 0.25), &λ), [0.625; 3]);
        let scene = load(MESH, &matte("face_age"), "", ColorMode::Rgb).unwrap();
        for (place, value) in [((0.75, 0.25), 0.75), ((0.25, 0.5), 0.5)] {
            assert_near(reflected(&scene, place, &λ), [value; 3]);
        }
    }

    /// A board on the same mesh has the file's coordinates, and so has an `aov` of them.
    #[test]
    fn other_textures_keep_their_places() {
        let board = r#"<bsdf type="blendbsdf"><texture type="mesh_attribute" name="weight"><string name="name" value="NAME"/></texture>
            <bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><float name="color0" value="0.9"/>
            <float name="color1" value="0.1"/></texture></bsdf><bsdf type="diffuse"/></bsdf>"#;
        let scene = load(MESH, &board.replace("NAME", "vertex_heat"), "", ColorMode::Rgb).unwrap();
        let λ = Wavelengths::rgb();
        for (x, y) in [(0.75, 0.25), (0.25, 0.5), (0.5, 0.9), (0.1, 0.7)] {
            let ray = Ray::free(DVec3::new(x, y, 1.0), -DVec3::Z);
            let hit = scene.accel.closest(&ray).unwrap();
            let (shape, point) = scene.surface::<{ Features::ALL }>(&ray, &hit);
            let uv = DVec2::new(0.2 * x, 0.8 * y);
            assert!((shape.geometry.file_uv(&point) - uv).length() < 1e-6, "{x} {y}");
            let value = scene.materials[shape.sides[0].material as usize].at(&point, &λ);
            let value = value.evaluate(DVec3::Z, DVec3::Z).value.0[0] * std::f32::consts::PI;
            let heat = if y < x { (x - y) + 0.5 * y } else { 0.5 * x + 0.25 * (y - x) };
            let colour = if (uv.x > 0.5) == (uv.y > 0.5) { 0.9 } else { 0.1 };
            assert!(
                (f64::from(value) - ((1.0 - heat) * colour + heat * 0.5)).abs() < 1e-6,
                "{x} {y}: {value}"
            );
        }
    }

    /// Spectra are interpolated, not their coefficients.
    #[test]
    fn between_vertices_spectra_are_means() {
        let λ = Wavelengths::sample_uniform(0.3, 400.0, 700.0);
        let scene = load(MESH, &matte("vertex_color"), "", ColorMode::Spectral).unwrap();
        let fit = |rgb| crate::spectrum::upsample::Upsampler::shared().fit(rgb).eval_lanes(&λ.nm);
        let [a, b, c] = [[0.1, 0.2, 0.3], [0.9, 0.1, 0.1], [0.4; 3]].map(fit);
        let mean = [0, 1, 2].map(|i| 0.25 * a[i] + 0.5 * b[i] + 0.25 * c[i]);
        assert_near(reflected(&scene, (0.75, 0.25), &λ), mean);
    }

    /// Whatever other colours a mesh has, and whether they are written as fractions or as bytes.
    #[test]
    fn a_colour_has_one_spectrum() {
        let upsampler = Upsampler::shared();
        let first = |colours: &[[f32; 3]], scale: f32| match Values::reflectances(colours, scale, &upsampler)
        {
            Values::Reflectance(values) => values[0],
            _ => panic!("no spectra"),
        };
        let lamp = [1.0, 0.5, 0.25];
        for brightest in [2.0, 1e6, 1e37] {
            assert_eq!(first(&[lamp, [brightest; 3]], 1.0), (1.0, upsampler.fit(lamp)));
        }
        assert_eq!(first(&[lamp, [0.5; 3]], 3.0), (3.0, upsampler.fit(lamp)));
        // What reflects, however it is written: no spectrum of it is above 1.
        assert_eq!(first(&[[0.25, 0.125, 0.0625]], 4.0), (1.0, upsampler.fit(lamp)));
        for brightest in [60.0, 255.0] {
            let (factor, spectrum) = first(&[[60.0, 12.0, 8.0], [brightest; 3]], 1.0 / 255.0);
            let expected = upsampler.fit([60.0, 12.0, 8.0].map(|byte| byte / 255.0));
            assert_eq!(factor, 1.0);
            assert!((0..3).all(|i| (spectrum.0[i] / expected.0[i] - 1.0).abs() < 1e-4), "{spectrum:?}");
        }
    }

    /// A material that stands by itself is read where a mesh has it, and each mesh has its own.
    #[test]
    fn what_has_no_such_attribute_is_told() {
        let refused = |mesh: &str, on_mesh: &str, elsewhere: &str| {
            load(mesh, on_mesh, elsewhere, ColorMode::Rgb).map(drop).unwrap_err().to_string()
        };
        let named = matte("vertex_color").replace("<bsdf", r#"<bsdf id="m""#);
        assert!(load(MESH, r#"<ref id="m"/>"#, &named, ColorMode::Rgb).is_ok());
        let spectrum = matte("vertex_color").replace("texture", "spectrum");
        assert!(load(MESH, &spectrum, "", ColorMode::Rgb).is_ok());
        let lamp = r#"<emitter type="area" id="lamp"><texture type="mesh_attribute" name="radiance">
            <string name="name" value="vertex_color"/></texture></emitter>"#;
        assert!(load(MESH, r#"<ref id="lamp"/>"#, lamp, ColorMode::Rgb).is_ok());
        for (error, parts) in [
            (refused(MESH, &matte("vertex_colour"), ""), ["no attribute `vertex_colour`", "vertex_color"]),
            (refused(MESH, &matte(""), ""), ["no attribute ``", "vertex_color, vertex_heat, face_age"]),
            (
                refused(&MESH.replace("0.9 0.1", "1.9 0.1"), &matte("vertex_color"), ""),
                ["of vertex 1 is 1.9", "0 to 1"],
            ),
            (
                refused(&MESH.replace("0.75\n", "-1\n"), &matte("face_age"), ""),
                ["of triangle 0 is -1", "0 to 1"],
            ),
            (
                refused(MESH, "", &format!(r#"<shape type="sphere">{}</shape>"#, matte("vertex_color"))),
                ["no mesh here", "of a `ply`"],
            ),
            (
                refused(
                    MESH,
                    r#"<bsdf type="bumpmap"><texture type="mesh_attribute"><string name="name" value="vertex_heat"/></texture>
                    <bsdf type="diffuse"/></bsdf>"#,
                    "",
                ),
                ["no slope", "expected a bitmap"],
            ),
            (
                refused(
                    MESH,
                    r#"<bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance"/></bsdf>"#,
                    "",
                ),
                ["needs a `name`", "vertex_color"],
            ),
        ] {
            assert!(parts.iter().all(|part| error.contains(part)), "{parts:?}: {error}");
        }
    }
}
