//! Meshes in Wavefront OBJ files.

use super::{Geometry, mesh_data, mesh_file, placement};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "obj";
pub const ABOUT: &str = "A Wavefront OBJ mesh.";
pub const EXAMPLES: &[&str] = &[];

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let placement = placement(params)?;
    let flip_texture = params.boolean("flip_tex_coords", true, "whether v counts from the top")?;
    mesh_file::parse(params, &placement, |path| mesh_data::read_obj(path, flip_texture))
}
