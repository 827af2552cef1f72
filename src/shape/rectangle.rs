//! A flat rectangle.

use super::patch::{Outline, Patch};
use super::{Geometry, placement};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "rectangle";
pub const ABOUT: &str =
    "The square from (−1, −1, 0) to (1, 1, 0), facing +z; any affine transform may place it.";
pub const EXAMPLES: &[&str] = &[
    r#"<shape type="rectangle"/>"#,
    r#"<shape type="rectangle"><boolean name="flip_normals" value="true"/>
        <transform name="to_world"><scale x="2"/><rotate x="1" angle="30"/></transform></shape>"#,
];

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let (to_world, flip) = placement(params)?;
    params.boolean("face_normals", false, "Mitsuba's; ignored, for it is flat")?;
    Ok(Geometry::Patch(Patch::new(&to_world, flip, Outline::Square)))
}
