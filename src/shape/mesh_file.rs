//! Parameters that all shapes read from mesh files have.

use super::mesh_data::{MeshData, MeshError};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use std::path::Path;

/// Reads the file that `filename` names, and whether its triangles shall be flat.
pub fn parse(
    params: &mut Params,
    read: impl FnOnce(&Path) -> Result<MeshData, MeshError>,
) -> Result<(MeshData, bool), SceneError> {
    let found = params.file("filename", "the mesh")?;
    let face_normals =
        params.boolean("face_normals", false, "flat triangles, whatever normals the file has")?;
    let (path, place) =
        found.ok_or_else(|| params.error("filename", "a mesh needs a `filename`", "add one"))?;
    let damaged = |e| {
        let message = format!("{}: {e}", path.display());
        SceneError::at(&place.value_span, message, "expected a whole mesh of this format")
    };
    let mesh = read(&path).map_err(damaged)?;
    Ok((mesh, face_normals))
}
