//! Scenes from strings: building blocks of the scenes of closed forms and metamorphic relations, and their
//! rendering.
//!
//! World space is right-handed with z up; lengths have no unit.

use etalon::image::Image as Rendered;
use etalon::load_text;
use etalon::render::{Progress, Settings, render};
use etalon::scene::Scene;
use etalon::spectrum::ColorMode;
use validation::image::{Channel, Image};
use validation::{Outcome, Verdict};

/// A point or direction.
pub type Point = [f64; 3];

/// A whole scene of these parts.
pub fn scene(parts: &[&str]) -> String {
    format!("<scene version=\"3.0.0\">{}</scene>", parts.concat())
}

/// `x, y, z`.
pub fn list([x, y, z]: Point) -> String {
    format!("{x}, {y}, {z}")
}

/// A path integrator with paths of at most `max_depth` edges and without roulette; −1 means no limit, with
/// roulette as usual.
pub fn path(max_depth: i64) -> String {
    let roulette = if max_depth < 0 { 5 } else { max_depth + 1 };
    format!(
        "<integrator type=\"path\"><integer name=\"max_depth\" value=\"{max_depth}\"/>\
         <integer name=\"rr_depth\" value=\"{roulette}\"/></integrator>"
    )
}

/// A box-filtered film.
pub fn film(width: u32, height: u32) -> String {
    format!(
        "<film type=\"hdrfilm\"><integer name=\"width\" value=\"{width}\"/>\
         <integer name=\"height\" value=\"{height}\"/><rfilter type=\"box\"/></film>"
    )
}

/// A transform `to_world` of these steps, in the order of their application.
pub fn to_world(steps: &[String]) -> String {
    format!("<transform name=\"to_world\">{}</transform>", steps.concat())
}

pub fn look_at(origin: Point, target: Point, up: Point) -> String {
    let [origin, target, up] = [origin, target, up].map(list);
    format!("<lookat origin=\"{origin}\" target=\"{target}\" up=\"{up}\"/>")
}

pub fn scale([x, y, z]: Point) -> String {
    format!("<scale x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")
}

/// A rotation about the axis `x`, `y` or `z`.
pub fn rotate(axis: char, degrees: f64) -> String {
    format!("<rotate {axis}=\"1\" angle=\"{degrees}\"/>")
}

pub fn translate([x, y, z]: Point) -> String {
    format!("<translate x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")
}

/// A pinhole camera with a horizontal field of view in degrees.
pub fn pinhole(place: &str, degrees: f64, film: &str) -> String {
    let to_world = to_world(&[place.into()]);
    format!(
        "<sensor type=\"perspective\"><float name=\"fov\" value=\"{degrees}\"/>\
         <string name=\"fov_axis\" value=\"x\"/>{to_world}{film}</sensor>"
    )
}

/// A pinhole camera of one pixel that looks at a point: its field of view is 10⁻⁵ rad.
pub fn pointed(origin: Point, target: Point) -> String {
    // An up vector that is parallel to no viewing direction of a case.
    let place = look_at(origin, target, [0.1, 0.3, 0.2]);
    pinhole(&place, 1e-5f64.to_degrees(), &film(1, 1))
}

/// A shape with its transform and further content, such as its material and emitter.
pub fn shape(kind: &str, steps: &[String], wears: &str) -> String {
    format!("<shape type=\"{kind}\">{}{wears}</shape>", to_world(steps))
}

pub fn sphere(center: Point, radius: f64, wears: &str) -> String {
    let [x, y, z] = center;
    format!(
        "<shape type=\"sphere\"><point name=\"center\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\
         <float name=\"radius\" value=\"{radius}\"/>{wears}</shape>"
    )
}

/// A grey colour in both colour modes.
pub fn grey(name: &str, value: f64) -> String {
    format!("<rgb name=\"{name}\" value=\"{value}\"/>")
}

pub fn float(name: &str, value: f64) -> String {
    format!("<float name=\"{name}\" value=\"{value}\"/>")
}

pub fn bsdf(kind: &str, parameters: &str) -> String {
    format!("<bsdf type=\"{kind}\">{parameters}</bsdf>")
}

pub fn diffuse(reflectance: f64) -> String {
    bsdf("diffuse", &grey("reflectance", reflectance))
}

pub fn emitter(kind: &str, parameters: &str) -> String {
    format!("<emitter type=\"{kind}\">{parameters}</emitter>")
}

pub fn area(radiance: f64) -> String {
    emitter("area", &grey("radiance", radiance))
}

pub fn constant(radiance: f64) -> String {
    emitter("constant", &grey("radiance", radiance))
}

/// Reads a scene; files that it names are searched beside the reference scenes.
pub fn load(text: &str, mode: ColorMode) -> Result<Scene, String> {
    let place = crate::references::folder().join("scenes/stage.xml");
    load_text(&place.to_string_lossy(), text, mode).map_err(|e| e.to_string())
}

/// Renders with one thread, since cases run in parallel. Errors: a sample that is not finite.
pub fn expose(scene: &Scene, settings: &Settings) -> Result<Rendered, String> {
    let (image, report) = render(scene, settings, &Progress::default()).map_err(|e| e.to_string())?;
    match report.first_non_finite.first() {
        Some(first) => Err(format!("{} samples are not finite, first {first:?}", report.non_finite)),
        None => Ok(image),
    }
}

/// Converts an image to the harness's type.
pub fn measured(image: &Rendered) -> Image {
    let double = |values: &Vec<f32>| values.iter().map(|&v| f64::from(v)).collect();
    let channel = |c: &etalon::image::Channel| Channel {
        name: c.name.clone(),
        mean: double(&c.mean),
        variance: c.variance.as_ref().map(double),
    };
    Image {
        width: image.crop.width as usize,
        height: image.crop.height as usize,
        channels: image.channels.iter().map(channel).collect(),
    }
}

/// The name of a family and the function that returns its cases.
pub type Family<T> = (&'static str, fn() -> Vec<T>);

/// The members of all families, each renamed `family::member`.
pub fn gather<T>(families: &[Family<T>], name: fn(&mut T) -> &mut String) -> Vec<T> {
    let mut all = vec![];
    for (family, members) in families {
        for mut member in members() {
            let name = name(&mut member);
            *name = format!("{family}::{name}");
            all.push(member);
        }
    }
    all
}

/// Effort and seed number of each run of a test: a fault counts if four times the samples with other seeds
/// confirm it.
pub const TWICE: [(u64, u64); 2] = [(1, 0), (4, 1)];

/// Repeats a check until a run finds no fault; fails with the fault of the last run.
pub fn confirmed(
    tries: &[(u64, u64)],
    fault: impl Fn(u64, u64) -> Result<Option<String>, String>,
) -> Result<(), String> {
    let mut found = String::new();
    for &(effort, number) in tries {
        match fault(effort, number)? {
            None => return Ok(()),
            Some(message) => found = message,
        }
    }
    Err(found)
}

/// The outcome of a check with seed `number`, or if that is different, with another seed: of hundreds of
/// checks that each err with probability 1 % some will err once, and hardly any twice.
pub fn asked_again(number: u64, check: impl Fn(u64) -> Result<Outcome, String>) -> Result<Outcome, String> {
    // Larger than any number in use.
    const ANOTHER: u64 = 1 << 32;
    let outcome = check(number)?;
    if outcome.verdict == Verdict::Different { check(number + ANOTHER) } else { Ok(outcome) }
}

/// The reason why an outcome is not equivalent, if it is not.
pub fn fault(outcome: &Outcome) -> Option<String> {
    (outcome.verdict != Verdict::Equivalent).then(|| format!("{}: {}", outcome.verdict, outcome.message))
}
