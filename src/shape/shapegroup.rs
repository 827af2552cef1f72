//! Shapes that are stored once and seen through any number of instances.

use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "shapegroup";
pub const ABOUT: &str = "Shapes that are not seen themselves, but through every `instance` of the group.";
pub const EXAMPLES: &[&str] = &[r#"<shape type="shapegroup"><shape type="sphere"/>
    <shape type="disk"><transform name="to_world"><translate y="-1"/></transform></shape></shape>"#];

/// The members are read where materials are known.
pub fn parse(params: &mut Params) -> Result<(), SceneError> {
    params.objects("shape", "the members: shapes that do not shine, in the group's own coordinates");
    Ok(())
}
