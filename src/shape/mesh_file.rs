//! Parameters that all shapes read from mesh files have.

use super::Geometry;
use super::mesh::{Mesh, Normals};
use super::mesh_data::{MeshData, MeshError};
use crate::math::Transform;
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use std::path::Path;

/// Reads the file that `filename` names, and whether its triangles shall be flat; the mesh is placed as
/// [`placement`](super::placement) has it.
pub fn parse(
    params: &mut Params,
    (to_world, flipped): &(Transform, bool),
    read: impl FnOnce(&Path) -> Result<MeshData, MeshError>,
) -> Result<Geometry, SceneError> {
    let found = params.file("filename", "the mesh")?;
    let of_faces = params.boolean("face_normals", false, "flat triangles, whatever normals the file has")?;
    let (path, place) =
        found.ok_or_else(|| params.error("filename", "a mesh needs a `filename`", "add one"))?;
    let damaged = |e| {
        let message = format!("{}: {e}", path.display());
        SceneError::at(&place.value_span, message, "expected a whole mesh of this format")
    };
    let mesh = read(&path).map_err(damaged)?;
    Ok(Geometry::Mesh(Mesh::new(mesh, to_world, Normals { of_faces, flipped: *flipped })))
}
