//! An instance of a group of shapes.

use super::shapegroup;
use crate::math::Transform;
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "instance";
pub const ABOUT: &str =
    "A `shapegroup` in a place; its shapes are held in memory once, whatever the number of instances.";
pub const EXAMPLES: &[&str] = &[r#"<shape type="instance">
    <shape type="shapegroup"><shape type="sphere"/></shape>
    <transform name="to_world"><scale x="2" y="0.5"/><translate x="3"/></transform></shape>"#];

/// The group is read where materials are known.
pub fn parse(params: &mut Params) -> Result<Transform, SceneError> {
    let to_world = params.transform("to_world", "from the group's coordinates to the world's")?;
    let group = params.object("shape", "the `shapegroup`, as a rule by <ref>")?;
    let kind = group.and_then(|g| g.attribute("type")).map(|a| a.value.as_str());
    match (group, kind) {
        (_, Some(shapegroup::NAME)) => {}
        (Some(other), _) => {
            let message = "an instance of a shape that is no group";
            return Err(SceneError::at(&other.span, message, "expected a `shapegroup`"));
        }
        (None, _) => return Err(params.lacks("shape", "expected a <ref> to a `shapegroup`")),
    }
    // Directions are transformed and normalised: squares must neither overflow nor vanish.
    const LARGEST: f64 = 1e100;
    let entries = to_world.matrix.to_cols_array().into_iter().chain(to_world.inverse.to_cols_array());
    if entries.map(f64::abs).any(|v| v.is_nan() || v > LARGEST) {
        let expected =
            format!("expected factors between {} and {LARGEST:e}", format_args!("{:e}", 1.0 / LARGEST));
        return Err(params.error("to_world", "this transform overflows", expected));
    }
    Ok(to_world)
}
