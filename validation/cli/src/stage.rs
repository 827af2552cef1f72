//! Scenes from strings: the pieces that closed forms and metamorphic relations are built of, and how they are
//! rendered.
//!
//! World space is right-handed with z up; lengths have no unit.

use etalon::image::Image as Rendered;
use etalon::render::{Progress, Settings, render};
use etalon::scene::{Scene, load_text};
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

/// A path integrator with this longest path and no roulette on it; −1 has no limit, and roulette as usual.
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

/// A transform `to_world` of these steps, the first one applied first.
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

/// About `x`, `y` or `z`.
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
    // An up that no case looks along.
    let place = look_at(origin, target, [0.1, 0.3, 0.2]);
    pinhole(&place, 1e-5f64.to_degrees(), &film(1, 1))
}

/// A shape with its transform and whatever it wears.
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

/// Reads a scene; files it names are looked for beside the reference scenes.
pub fn load(text: &str, mode: ColorMode) -> Result<Scene, String> {
    let place = crate::references::folder().join("scenes/stage.xml");
    load_text(&place.to_string_lossy(), text, mode).map_err(|e| e.to_string())
}

/// Renders with one thread: cases run side by side. A value that is not finite is an error.
pub fn expose(scene: &Scene, settings: &Settings) -> Result<Rendered, String> {
    let (image, report) = render(scene, settings, &Progress::default()).ok_or("the render stopped")?;
    match report.first_non_finite.first() {
        Some(first) => Err(format!("{} samples are not finite, first {first:?}", report.non_finite)),
        None => Ok(image),
    }
}

/// The image as the harness knows it.
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

/// A name and the cases that bear it.
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

/// Efforts and numbers of seeds that a test has: a fault counts if four times the samples, of other seeds,
/// confirm it.
pub const TWICE: [(u64, u64); 2] = [(1, 0), (4, 1)];

/// Checks until a try finds no fault; fails with what the last one found.
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

/// The answer that a check gives of a number, or where that is a difference, of another: of hundreds of questions
/// of which each errs once in a hundred times some will, and hardly any twice.
pub fn asked_again(number: u64, check: impl Fn(u64) -> Result<Outcome, String>) -> Result<Outcome, String> {
    // That nobody counts to.
    const ANOTHER: u64 = 1 << 32;
    let outcome = check(number)?;
    if outcome.verdict == Verdict::Different { check(number + ANOTHER) } else { Ok(outcome) }
}

/// What keeps an outcome from being an approval.
pub fn fault(outcome: &Outcome) -> Option<String> {
    (outcome.verdict != Verdict::Equivalent).then(|| format!("{}: {}", outcome.verdict, outcome.message))
}
