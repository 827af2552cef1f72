//! Meshes in Mitsuba’s serialized format.

use super::{Geometry, mesh_data, mesh_file, placement};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "serialized";
pub const ABOUT: &str = "A mesh in Mitsuba's compressed format, which may hold several.";
pub const EXAMPLES: &[&str] = &[];

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let placement = placement(params)?;
    let index = params.count("shape_index", 0, 0..=u32::MAX, "which mesh of the file")?;
    mesh_file::parse(params, &placement, |path| mesh_data::read_serialized(path, index))
}
