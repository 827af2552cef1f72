//! Variations of an example: other numbers, colours, textures and nested materials.

use super::models::Models;
use super::node::Node;
use crate::draw::Draw;

/// Largest depth of nested materials.
pub const DEPTH: usize = 2;

/// Draws elements of scenes.
pub struct Grower<'a> {
    pub models: &'a Models,
    pub draw: &'a mut Draw,
    /// Whether the scene is spectral. In RGB mode some plugins do not accept spectra.
    pub spectral: bool,
}

impl Grower<'_> {
    /// A varied example of a random model of this kind; only examples that `fits` accepts are used.
    pub fn any(&mut self, kind: &str, depth: usize, fits: impl Fn(&Node) -> bool) -> Option<Node> {
        let kinds = self.models.of(kind);
        let fitting = |k: &&&super::models::Kind| k.examples.iter().any(&fits);
        let kinds: Vec<_> = kinds.iter().filter(fitting).collect();
        let chosen = kinds.get(self.draw.below(kinds.len()))?;
        let examples: Vec<&Node> = chosen.examples.iter().filter(|e| fits(e)).collect();
        let mut node = (*examples.get(self.draw.below(examples.len()))?).clone();
        self.vary(&mut node, depth);
        Some(node)
    }

    pub fn material(&mut self, depth: usize) -> Option<Node> {
        self.any("bsdf", depth, |_| true)
    }

    /// Varies parameters, and adds switches and factors that the model has.
    pub fn vary(&mut self, node: &mut Node, depth: usize) {
        for child in &mut node.children {
            match child.tag.as_str() {
                "float" => self.float(child),
                "rgb" => self.colour(child),
                "spectrum" if child.get("value").is_some() => self.numbers(child, "value"),
                "string" if child.get("name") == Some("values") => self.numbers(child, "value"),
                "bsdf" if depth > 0 && self.draw.chance(0.6) => {
                    let name = child.get("name").map(str::to_owned);
                    if let Some(mut other) = self.material(depth - 1) {
                        if let Some(name) = name {
                            other.set("name", &name);
                        }
                        *child = other;
                    }
                }
                "bsdf" | "shape" | "texture" | "spectrum" => self.vary(child, depth),
                _ => {}
            }
        }
        let Some(model) = self.models.model(node) else { return };
        for parameter in &model.parameters {
            let (name, kind) = (parameter.name, parameter.kind);
            let present = node.children.iter().position(|c| c.get("name") == Some(name));
            let factor = name.contains("reflectance") || name.contains("transmittance");
            match present {
                None if kind == "boolean" && self.draw.chance(0.15) => {
                    let value = if self.draw.chance(0.5) { "true" } else { "false" };
                    node.children.push(Node::new("boolean", &[("name", name), ("value", value)]));
                }
                None if kind == "texture" && factor && self.draw.chance(0.15) => {
                    let mut colour = Node::new("rgb", &[("name", name), ("value", "0.5")]);
                    self.colour(&mut colour);
                    node.children.push(colour);
                }
                Some(i) if kind == "texture" && node.tag == "bsdf" && self.draw.chance(0.25) => {
                    if let Some(texture) = self.texture_for(&node.children[i], name) {
                        node.children[i] = texture;
                    }
                }
                _ => {}
            }
        }
    }

    /// A texture to replace a number or a colour; `None` if the parameter takes none.
    fn texture_for(&mut self, old: &Node, name: &str) -> Option<Node> {
        let mut texture = match old.tag.as_str() {
            "float" if !["eta", "k"].contains(&name) => {
                let number = |draw: &mut Draw, name| {
                    let value = format!("{:.3}", draw.between(0.1, 0.9));
                    Node::new("float", &[("name", name), ("value", &value)])
                };
                Node::new("texture", &[("type", "checkerboard")])
                    .with(number(self.draw, "color0"))
                    .with(number(self.draw, "color1"))
            }
            "rgb" if !["eta", "k"].contains(&name) => self.any("texture", 0, |n| n.tag == "texture")?,
            _ => return None,
        };
        texture.set("name", name);
        Some(texture)
    }

    fn float(&mut self, node: &mut Node) {
        let Some(old) = node.get("value").and_then(|v| v.parse::<f64>().ok()) else { return };
        let factor = self.draw.between(0.6, 1.4);
        let ior = node.get("name").is_some_and(|n| n.ends_with("ior"));
        let new = match old {
            // An index of refraction next to 1 has no visible effect, and caustics through it converge too
            // slowly.
            _ if ior && old > 1.0 => 1.0 + (old - 1.0) * factor,
            _ if (0.0..=1.0).contains(&old) && !ior => (old * factor).clamp(0.08, 0.95),
            _ if ior => old,
            _ => old * factor,
        };
        node.set("value", &format!("{new:.4}"));
    }

    fn colour(&mut self, node: &mut Node) {
        let old: Vec<f64> =
            split(node.get("value").unwrap_or_default()).filter_map(|v| v.parse().ok()).collect();
        let most = old.iter().copied().fold(0.0, f64::max);
        let reach = if most <= 1.0 { 0.9 } else { 1.4 * most };
        // What is wholly black in a channel, or in all, is dark to some paths and not to their neighbours.
        let one = |draw: &mut Draw| match draw.chance(0.12) {
            true => "0".to_owned(),
            false => format!("{:.3}", draw.between(0.05 * reach, reach)),
        };
        let value = [one(self.draw), one(self.draw), one(self.draw)].join(", ");
        node.set("value", &value);
    }

    /// Multiplies the values of a list such as `400:0.1, 700:0.9` by random factors.
    fn numbers(&mut self, node: &mut Node, attribute: &str) {
        let old = node.get(attribute).unwrap_or_default().to_owned();
        let one = |text: &str, draw: &mut Draw| {
            let (place, value) = text.split_once(':').map_or(("", text), |(p, v)| (p, v));
            let number = value.parse::<f64>().unwrap_or(0.5) * draw.between(0.5, 1.05);
            if place.is_empty() { format!("{number:.4}") } else { format!("{place}:{number:.4}") }
        };
        let values: Vec<String> = split(&old).map(|text| one(text, self.draw)).collect();
        node.set(attribute, &values.join(", "));
    }
}

fn split(text: &str) -> impl Iterator<Item = &str> {
    text.split([',', ' ']).filter(|part| !part.is_empty())
}
