//! A room of things that bend and mirror light, for techniques that follow light through them.
//!
//! Lamps are large enough for plain path tracing to find them by chance.

use super::grammar::{floor, look_at, sensor};
use super::models::Models;
use super::node::Node;
use super::vary::{DEPTH, Grower};
use crate::draw::Draw;

/// Materials of casters; smooth glass is drawn most often, for most techniques are about it.
const CASTERS: &[&str] = &[
    "dielectric",
    "dielectric",
    "dielectric",
    "thindielectric",
    "conductor",
    "roughdielectric",
    "roughconductor",
    "plastic",
    "roughplastic",
    "principled",
    "principledthin",
    "mask",
    "twosided",
    "blendbsdf",
    "bumpmap",
    "normalmap",
];

/// Materials of sheets, which lie between the lamps and the other things.
const SHEETS: &[&str] =
    &["dielectric", "thindielectric", "thindielectric", "conductor", "mask", "null", "twosided", "diffuse"];

/// A scene whose integrator is `path` with nothing but the length of paths, and its colour mode.
pub struct Scene {
    pub root: Node,
    pub spectral: bool,
}

/// Scene `number`, whose mesh and texture files are in `folder`.
pub fn scene(models: &Models, folder: &str, number: u64) -> Option<Scene> {
    let mut draw = Draw::named("casters", number);
    (0..100).find_map(|_| drawn(models, folder, &mut draw))
}

fn drawn(models: &Models, folder: &str, draw: &mut Draw) -> Option<Scene> {
    let spectral = draw.chance(0.3);
    let mut grower = Grower { models, draw, spectral };
    let mut root = Node::new("scene", &[("version", "3.0.0")]);
    root.children.push(Node::new("path", &[("value", folder)]));
    let depth = (3 + grower.draw.below(5)).to_string();
    let integrator = Node::new("integrator", &[("type", "path")]);
    root.children.push(integrator.with(Node::new("integer", &[("name", "max_depth"), ("value", &depth)])));
    // Of samples that count in one pixel only, whose noise is independent.
    let (sensor, boxed) = sensor(&mut grower)?;
    if !boxed || sensor.all().iter().any(|n| n.is("film", "specfilm")) {
        return None;
    }
    root.children.push(sensor);
    root.children.push(floor(&mut grower)?);
    for _ in 0..=grower.draw.below(2) {
        root.children.push(lamp(&mut grower)?);
    }
    if grower.draw.chance(0.2) {
        root.children.push(grower.any("emitter", 0, |n| n.is("emitter", "constant"))?);
    }
    for number in 0..=grower.draw.below(4) {
        root.children.push(caster(&mut grower, number)?);
    }
    for heights in [[1.5, 1.8], [1.9, 2.3]] {
        if grower.draw.chance(0.4) {
            root.children.extend(sheets(&mut grower, heights)?);
        }
    }
    Some(Scene { root, spectral })
}

fn number(name: &str, value: f64) -> (String, String) {
    (name.into(), format!("{value:.3}"))
}

/// An element whose attributes are numbers.
fn numbered(tag: &str, values: &[(&str, f64)]) -> Node {
    let mut node = Node::new(tag, &[]);
    node.attributes = values.iter().map(|(name, value)| number(name, *value)).collect();
    node
}

fn to_world(steps: impl IntoIterator<Item = Node>) -> Node {
    steps.into_iter().fold(Node::new("transform", &[("name", "to_world")]), Node::with)
}

fn turned(grower: &mut Grower) -> impl Iterator<Item = Node> {
    let angles = [(); 3].map(|()| grower.draw.between(-180.0, 180.0));
    ["x", "y", "z"].into_iter().zip(angles).map(|(axis, angle)| {
        let mut step = Node::new("rotate", &[(axis, "1")]);
        step.attributes.push(number("angle", angle));
        step
    })
}

/// A lamp above that faces the floor, more or less; it may be dressed in something that reflects.
fn lamp(grower: &mut Grower) -> Option<Node> {
    let kind = *grower.draw.of(&["rectangle", "rectangle", "disk", "sphere", "cube"]);
    let mut at = |most: f64| grower.draw.between(-most, most);
    let (x, z, aside) = (at(1.5), at(1.0), at(1.0));
    let (size, height) = (grower.draw.between(0.8, 1.6), grower.draw.between(2.6, 4.0));
    let place = to_world([
        numbered("scale", &[("value", size)]),
        look_at(&format!("{x:.3}, {height:.3}, {z:.3}"), &format!("{:.3}, 0, {z:.3}", x + aside)),
    ]);
    let lit = grower.any("emitter", 0, |n| n.is("emitter", "area"))?;
    let lamp = Node::new("shape", &[("type", kind)]).with(place).with(lit);
    Some(if grower.draw.chance(0.3) { lamp.with(material(grower, CASTERS)?) } else { lamp })
}

fn material(grower: &mut Grower, of: &[&str]) -> Option<Node> {
    let kind = *grower.draw.of(of);
    grower.any("bsdf", DEPTH, |n| n.is("bsdf", kind))
}

/// Something above the floor.
fn caster(grower: &mut Grower, which: usize) -> Option<Node> {
    const KINDS: &[&str] =
        &["sphere", "sphere", "cube", "cube", "disk", "rectangle", "cylinder", "obj", "ply"];
    let kind = *grower.draw.of(KINDS);
    let mut node = grower.any("shape", 1, |n| n.is("shape", kind))?;
    node.children.retain(|c| c.tag != "transform");
    let size = grower.draw.between(0.35, 0.7);
    let even = ["sphere", "cylinder"].contains(&kind) || grower.draw.chance(0.4);
    let mut side = || if even { size } else { size * grower.draw.between(0.4, 1.4) };
    let scale = numbered("scale", &[("x", side()), ("y", side()), ("z", side())]);
    let turns: Vec<Node> = if grower.draw.chance(0.7) { turned(grower).collect() } else { vec![] };
    // Close enough to overlap now and then.
    let x = [0.0, -1.1, 1.0, 0.1][which % 4] + grower.draw.between(-0.3, 0.3);
    let (y, z) = (grower.draw.between(0.5, 1.0), grower.draw.between(-0.6, 0.6));
    let steps = [vec![scale], turns, vec![numbered("translate", &[("x", x), ("y", y), ("z", z)])]].concat();
    Some(node.with(to_world(steps)).with(material(grower, CASTERS)?))
}

/// A pane, a slab or a row of slats below the lamps.
fn sheets(grower: &mut Grower, [lowest, highest]: [f64; 2]) -> Option<Vec<Node>> {
    let wears = material(grower, SHEETS)?;
    let height = grower.draw.between(lowest, highest);
    let sheet = |kind: &str, (wide, thick, long): (f64, f64, f64), z: f64| {
        let scale = numbered("scale", &[("x", wide), ("y", long), ("z", thick)]);
        let flat = Node::new("rotate", &[("x", "1"), ("angle", "-90")]);
        let place = to_world([scale, flat, numbered("translate", &[("x", 0.0), ("y", height), ("z", z)])]);
        Node::new("shape", &[("type", kind)]).with(place).with(wears.clone())
    };
    Some(match grower.draw.below(3) {
        0 => vec![sheet("rectangle", (1.5, 1.0, 1.5), 0.0)],
        1 => vec![sheet("cube", (2.5, grower.draw.between(0.05, 0.4), 2.5), 0.0)],
        _ => {
            let gap = grower.draw.between(0.2, 0.5);
            (-5..6).map(|i| sheet("rectangle", (2.0, 1.0, 0.3 * gap), gap * f64::from(i))).collect()
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_scene_and_all_that_casts_gets_its_turn() {
        let models = Models::read().unwrap();
        let scenes: Vec<Scene> = (0..200).map(|n| scene(&models, ".", n).unwrap()).collect();
        assert_eq!(scenes[7].root, scene(&models, ".", 7).unwrap().root);
        for kind in CASTERS.iter().chain(SHEETS) {
            let wearing = scenes.iter().filter(|s| s.root.all().iter().any(|n| n.is("bsdf", kind))).count();
            assert!(wearing > 3, "{kind}: {wearing}");
        }
    }
}
