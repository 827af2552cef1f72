//! A small room, furnished at random from all models.
//!
//! What would make a comparison too noisy to decide is not drawn: lamps are large, films small.

use super::known;
use super::models::Models;
use super::node::Node;
use super::vary::{DEPTH, Grower};
use crate::draw::Draw;

/// Pixels along each side of the film.
pub const SIZE: u32 = 24;

/// A scene with what its comparison depends on.
pub struct Scene {
    /// The scene file.
    pub text: String,
    /// `rgb` or `spectral`.
    pub mode: &'static str,
    /// Whether the filter is a box, so that each sample counts in one pixel only and the noise of pixels is
    /// independent.
    pub boxed: bool,
    /// The scene's elements, as `tag:type`.
    pub models: Vec<String>,
}

/// Scene `number`, whose mesh and texture files are in `folder`.
pub fn scene(models: &Models, folder: &str, number: u64) -> Option<Scene> {
    (0..100).find_map(|attempt| drawn(models, folder, &mut Draw::named(&format!("scene {attempt}"), number)))
}

/// A scene without known differences from Mitsuba; `None` if the draw has one.
fn drawn(models: &Models, folder: &str, draw: &mut Draw) -> Option<Scene> {
    let spectral = draw.chance(0.8);
    let mut grower = Grower { models, draw, spectral };
    let mut root = Node::new("scene", &[("version", "3.0.0")]);
    root.children.push(Node::new("path", &[("value", folder)]));
    root.children.push(integrator(&mut grower)?);
    let (sensor, boxed) = sensor(&mut grower)?;
    root.children.push(sensor);
    root.children.push(floor(&mut grower)?);
    root.children.extend(lights(&mut grower)?);
    for slot in SLOTS {
        if grower.draw.chance(0.7) {
            let mut object = unknown(&mut grower, |g| object(g, *slot))?;
            if root.all().iter().any(|n| n.is("integrator", "volpath")) {
                fill(&mut grower, &mut object)?;
            }
            root.children.extend(hoisted(object, root.children.len()));
        }
    }
    if !known::causes(&root).is_empty() {
        return None;
    }
    let named = |n: &&Node| n.get("type").map(|kind| format!("{}:{kind}", n.tag));
    let mut found: Vec<String> = root.all().iter().filter_map(named).collect();
    found.sort();
    found.dedup();
    let mode = if spectral { "spectral" } else { "rgb" };
    Some(Scene { text: root.to_string(), mode, boxed, models: found })
}

/// Integrators whose channels differ between renderers even in expectation: a mean square is a property of
/// the estimator, and Mitsuba's `volpathmis` is a little darker than its `volpath`.
const UNLIKE: &[&str] = &["moment", "volpathmis"];

/// Sensors of one pixel, which is too few to compare.
const METERS: &[&str] = &["radiancemeter", "distant", "irradiancemeter"];

/// Places of objects on the floor, as x and z.
const SLOTS: &[[f64; 2]] = &[[-1.5, 0.0], [0.0, 0.5], [1.5, 0.0], [-0.7, -1.4], [0.8, -1.4]];

/// Redraws until an element has no known difference from Mitsuba.
fn unknown(grower: &mut Grower, mut draw: impl FnMut(&mut Grower) -> Option<Node>) -> Option<Node> {
    (0..1000).find_map(|_| draw(grower).filter(|node| known::causes(node).is_empty()))
}

fn integrator(grower: &mut Grower) -> Option<Node> {
    let spectral = grower.spectral;
    let is_of = |n: &Node, kinds: &[&str]| kinds.iter().any(|kind| n.is("integrator", kind));
    // The channels of depths and AOVs have no colour.
    let fits = |n: &Node| !is_of(n, UNLIKE) && (!spectral || !is_of(n, &["depth", "aov"]));
    let mut node = unknown(grower, |g| g.any("integrator", 0, fits))?;
    let depth = (2 + grower.draw.below(4)).to_string();
    let deep = Node::new("integer", &[("name", "max_depth"), ("value", &depth)]);
    node.children.retain(|c| c.get("name") != Some("max_depth"));
    if is_of(&node, &["path", "volpath"]) {
        node.children.push(deep);
    }
    Some(node)
}

pub(super) fn sensor(grower: &mut Grower) -> Option<(Node, bool)> {
    let makes_image = |n: &Node| !METERS.iter().any(|kind| n.is("sensor", kind));
    let mut node = grower.any("sensor", 0, |n| !n.children.is_empty() && makes_image(n))?;
    node.children.retain(|c| c.tag != "transform");
    let mut place = Node::new("transform", &[("name", "to_world")]);
    if node.is("sensor", "orthographic") {
        place.children.push(Node::new("scale", &[("x", "2.5"), ("y", "2.5")]));
    }
    let (angle, height) = (grower.draw.between(-0.8, 0.8), grower.draw.between(1.0, 3.5));
    let origin = format!("{:.3}, {height:.3}, {:.3}", 6.0 * libm::sin(angle), 6.0 * libm::cos(angle));
    place.children.push(look_at(&origin, "0, 0.4, 0"));
    let (spectral, boxed) = (grower.spectral, grower.draw.chance(0.8));
    let banded = spectral && grower.draw.chance(0.1);
    let mut film = grower.any("film", 0, |n| n.is("film", if banded { "specfilm" } else { "hdrfilm" }))?;
    for name in ["width", "height"] {
        film.children.push(Node::new("integer", &[("name", name), ("value", &SIZE.to_string())]));
    }
    film.children.retain(|c| c.tag != "boolean");
    film.children.push(Node::new("string", &[("name", "component_format"), ("value", "float32")]));
    if !banded {
        let format = if grower.draw.chance(0.1) { "rgba" } else { "rgb" };
        film.children.push(Node::new("string", &[("name", "pixel_format"), ("value", format)]));
    }
    film.children.push(grower.any("rfilter", 0, |n| !boxed || n.is("rfilter", "box"))?);
    let boxed = film.all().iter().any(|n| n.is("rfilter", "box"));
    let sampler = Node::new("sampler", &[("type", "independent")]);
    Some((node.with(place).with(sampler).with(film), boxed))
}

pub(super) fn floor(grower: &mut Grower) -> Option<Node> {
    let place = Node::new("transform", &[("name", "to_world")])
        .with(Node::new("scale", &[("value", "8")]))
        .with(Node::new("rotate", &[("x", "1"), ("angle", "-90")]));
    let material = unknown(grower, |g| g.material(0))?;
    Some(Node::new("shape", &[("type", "rectangle")]).with(place).with(material))
}

fn lights(grower: &mut Grower) -> Option<Vec<Node>> {
    let mut found = vec![];
    let around = grower.draw.chance(0.8);
    if around {
        // Maps are drawn less often: small suns in them make caustics, which are noisy.
        let kind = if grower.draw.chance(0.2) { "envmap" } else { "constant" };
        found.push(grower.any("emitter", 0, |n| n.is("emitter", kind))?);
    }
    if !around || grower.draw.chance(0.6) {
        found.push(lamp(grower)?);
    }
    if grower.draw.chance(0.2) {
        let small = |n: &Node| !["area", "constant", "envmap"].iter().any(|kind| n.is("emitter", kind));
        let mut light = grower.any("emitter", 0, small)?;
        if light.is("emitter", "spot") {
            let place = Node::new("transform", &[("name", "to_world")]);
            light.children.push(place.with(look_at("1.5, 5, 2", "0, 0, 0")));
        }
        found.push(light);
    }
    Some(found)
}

fn lamp(grower: &mut Grower) -> Option<Node> {
    let angle = grower.draw.between(0.0, std::f64::consts::TAU);
    let origin = format!("{:.3}, 5, {:.3}", 4.0 * libm::cos(angle), 4.0 * libm::sin(angle));
    let kind = *grower.draw.of(&["rectangle", "disk", "sphere"]);
    let place = Node::new("transform", &[("name", "to_world")])
        .with(Node::new("scale", &[("value", "1.4")]))
        .with(look_at(&origin, "0, 0.5, 0"));
    let mut light = grower.any("emitter", 0, |n| n.is("emitter", "area"))?;
    if grower.spectral && grower.draw.chance(0.5) {
        let mut spectrum = unknown(grower, |g| g.any("texture", 0, |n| n.tag == "spectrum"))?;
        spectrum.set("name", "radiance");
        light.children = vec![spectrum];
    }
    Some(Node::new("shape", &[("type", kind)]).with(place).with(light))
}

fn object(grower: &mut Grower, [x, z]: [f64; 2]) -> Option<Node> {
    let mut node = grower.any("shape", 1, |n| !n.is("shape", "shapegroup"))?;
    node.children.retain(|c| c.tag != "transform");
    let size = grower.draw.between(0.35, 0.6);
    // A sphere cannot be scaled unevenly, nor can a cylinder in Mitsuba.
    let even = node.is("shape", "sphere") || node.is("shape", "cylinder") || grower.draw.chance(0.5);
    let mut side = || format!("{:.3}", if even { size } else { size * grower.draw.between(0.6, 1.4) });
    let scale = Node::new("scale", &[("x", &side()), ("y", &side()), ("z", &side())]);
    let mut place = Node::new("transform", &[("name", "to_world")]).with(scale);
    for axis in ["x", "y", "z"] {
        let angle = format!("{:.2}", grower.draw.between(-180.0, 180.0));
        place.children.push(Node::new("rotate", &[(axis, "1"), ("angle", &angle)]));
    }
    let [x, z] = [x, z].map(|v| format!("{v}"));
    place.children.push(Node::new("translate", &[("x", &x), ("y", "0.6"), ("z", &z)]));
    node.children.push(place);
    if !node.is("shape", "instance") {
        node.children.push(grower.material(DEPTH)?);
    }
    Some(node)
}

/// Puts a medium into a shape that encloses something, and often makes its surface invisible.
fn fill(grower: &mut Grower, object: &mut Node) -> Option<()> {
    let encloses = ["sphere", "cube"].iter().any(|kind| object.is("shape", kind));
    if !encloses || grower.draw.chance(0.2) {
        return Some(());
    }
    let mut medium = grower.any("medium", 0, |_| true)?;
    medium.set("name", "interior");
    if !medium.children.iter().any(|c| c.tag == "phase") {
        medium.children.push(grower.any("phase", 0, |_| true)?);
    }
    object.children.push(medium);
    if grower.draw.chance(0.7) {
        object.children.retain(|c| c.tag != "bsdf");
        object.children.push(Node::new("bsdf", &[("type", "null")]));
    }
    Some(())
}

/// Moves a shape group to the top level under an id, where Mitsuba requires it.
fn hoisted(mut object: Node, number: usize) -> Vec<Node> {
    let Some(place) = object.children.iter().position(|c| c.is("shape", "shapegroup")) else {
        return vec![object];
    };
    let id = format!("group{number}");
    let reference = Node::new("ref", &[("id", &id)]);
    let mut group = std::mem::replace(&mut object.children[place], reference);
    group.set("id", &id);
    vec![group, object]
}

pub(super) fn look_at(origin: &str, target: &str) -> Node {
    Node::new("lookat", &[("origin", origin), ("target", target), ("up", "0, 1, 0.01")])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_scene_and_every_model_gets_its_turn() {
        let models = Models::read().unwrap();
        let scenes: Vec<Scene> = (0..400).map(|n| scene(&models, ".", n).unwrap()).collect();
        assert_eq!(scenes[7].text, scene(&models, ".", 7).unwrap().text);
        let seen = |name: &String| scenes.iter().any(|s| s.models.contains(name));
        let names = models.all().flat_map(|k| k.examples.iter().map(move |e| (k, e)));
        // Mitsuba's other samplers do not give independent samples, which the comparison needs.
        let missing: Vec<String> = names
            .filter(|(k, _)| k.model.kind != "sampler" && ![UNLIKE, METERS].concat().contains(&k.model.name))
            .map(|(k, e)| format!("{}:{}", e.tag, k.model.name))
            .filter(|name| !seen(name))
            .collect();
        assert!(missing.is_empty(), "{missing:?}");
        let refused = scenes.iter().filter(|s| known::causes(&Node::parse(&s.text).unwrap()).is_empty());
        assert_eq!(refused.count(), scenes.len());
    }
}
