//! A flat disk.

use super::patch::{Outline, Patch};
use super::{Geometry, placement};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "disk";
pub const ABOUT: &str = "The disk of radius 1 in the plane z = 0, facing +z; scaling may make it an ellipse.";
pub const EXAMPLES: &[&str] = &[
    r#"<shape type="disk"/>"#,
    r#"<shape type="disk"><transform name="to_world"><scale x="2" y="0.5"/></transform></shape>"#,
];

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let (to_world, flip) = placement(params)?;
    Ok(Geometry::Patch(Patch::new(&to_world, flip, Outline::Circle)))
}
