//! Meshes in PLY files.

use super::{Geometry, mesh_data, mesh_file, placement};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "ply";
pub const ABOUT: &str = "A PLY mesh, ASCII or binary.";
pub const EXAMPLES: &[&str] = &[];

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let placement = placement(params)?;
    let flip_texture = params.boolean("flip_tex_coords", false, "whether v counts from the top")?;
    mesh_file::parse(params, &placement, |path| {
        mesh_data::read_ply(path).map(|m| m.with_flipped_texture(flip_texture))
    })
}
