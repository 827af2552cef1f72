//! The models of which scenes are made: the examples of Etalon's registries, and examples that need files or
//! Mitsuba's spelling.

use super::node::Node;
use etalon::scene::catalogue::{Model, catalogue};

/// Examples that the registries cannot contain because they need a file.
const WITH_FILES: &[&str] = &[
    r#"<shape type="ply"><string name="filename" value="meshes/ball.ply"/></shape>"#,
    r#"<shape type="ply"><string name="filename" value="meshes/octahedron.ply"/></shape>"#,
    r#"<shape type="ply"><string name="filename" value="meshes/square.ply"/></shape>"#,
    r#"<shape type="obj"><string name="filename" value="meshes/cube.obj"/></shape>"#,
    r#"<shape type="obj"><string name="filename" value="meshes/vase.obj"/></shape>"#,
    r#"<shape type="serialized"><string name="filename" value="meshes/pair.serialized"/></shape>"#,
    r#"<shape type="serialized"><string name="filename" value="meshes/pair.serialized"/>
        <integer name="shape_index" value="1"/></shape>"#,
    r#"<emitter type="envmap"><string name="filename" value="textures/sky.exr"/><float name="scale" value="0.8"/></emitter>"#,
    r#"<texture type="bitmap"><string name="filename" value="textures/tiles.png"/></texture>"#,
    r#"<texture type="bitmap"><string name="filename" value="textures/tiles.exr"/>
        <string name="wrap_mode" value="mirror"/><transform name="to_uv"><scale x="3" y="2"/></transform></texture>"#,
    r#"<texture type="bitmap"><string name="filename" value="textures/smooth.jpg"/>
        <string name="filter_type" value="nearest"/></texture>"#,
    r#"<texture type="bitmap"><string name="filename" value="textures/smooth.hdr"/>
        <string name="wrap_mode" value="clamp"/></texture>"#,
    r#"<bsdf type="normalmap"><texture name="normalmap" type="bitmap">
        <string name="filename" value="textures/normals.png"/><boolean name="raw" value="true"/></texture>
        <bsdf type="diffuse"/></bsdf>"#,
    r#"<bsdf type="bumpmap"><texture type="bitmap" name="height">
        <string name="filename" value="textures/heights.png"/><boolean name="raw" value="true"/></texture>
        <float name="scale" value="0.3"/><bsdf type="diffuse"/></bsdf>"#,
    r#"<volume type="gridvolume"><string name="filename" value="volumes/puff.vol"/></volume>"#,
    r#"<medium type="homogeneous"><volume name="albedo" type="gridvolume">
        <string name="filename" value="volumes/shades.vol"/></volume><float name="sigma_t" value="4"/></medium>"#,
    r#"<medium type="heterogeneous"><volume name="sigma_t" type="gridvolume">
        <string name="filename" value="volumes/puff.vol"/>
        <transform name="to_world"><scale value="2"/><translate x="-2" y="-0.5" z="-0.5"/></transform></volume>
        <float name="scale" value="5"/></medium>"#,
    r#"<film type="hdrfilm"/>"#,
    r#"<film type="specfilm"><spectrum name="band1" value="400:0, 450:1, 500:0"/>
        <spectrum name="band2" value="480:0, 520:0.8, 600:0.8, 640:0"/></film>"#,
];

/// The texture that can stand nowhere but on a mesh whose file has it. It is left out: what the grammar draws may stand
/// on any shape.
const ON_ITS_MESH: &str = "mesh_attribute";

/// A model and its examples.
pub struct Kind {
    pub model: Model,
    pub examples: Vec<Node>,
}

/// The models with their examples.
pub struct Models(Vec<Kind>);

impl Models {
    /// Reads the registries; a model without any example is an error.
    pub fn read() -> Result<Self, String> {
        let mut kinds = vec![];
        for model in catalogue().into_iter().filter(|model| model.name != ON_ITS_MESH) {
            let examples: Result<Vec<Node>, _> =
                model.examples.iter().map(|text| Node::parse(text)).collect();
            kinds.push(Kind { model, examples: examples? });
        }
        for text in WITH_FILES {
            let node = Node::parse(text)?;
            let home = kinds.iter_mut().find(|k| node.is(k.model.kind, k.model.name));
            home.ok_or_else(|| format!("no such model: {text}"))?.examples.push(node);
        }
        match kinds.iter().find(|k| k.examples.is_empty()) {
            Some(kind) => Err(format!("{} `{}` has no example", kind.model.kind, kind.model.name)),
            None => Ok(Self(kinds)),
        }
    }

    /// The models of a kind, such as `bsdf`.
    pub fn of(&self, kind: &str) -> Vec<&Kind> {
        self.0.iter().filter(|k| k.model.kind == kind).collect()
    }

    /// The model that an element names; `None` if it is unknown.
    pub fn model(&self, node: &Node) -> Option<&Model> {
        self.0.iter().map(|k| &k.model).find(|m| node.is(m.kind, m.name))
    }

    pub fn all(&self) -> impl Iterator<Item = &Kind> {
        self.0.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_has_an_example() {
        assert!(Models::read().unwrap().all().count() > 40);
    }
}
