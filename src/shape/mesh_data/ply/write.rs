//! Writing PLY, for meshes that programs make.

use super::super::MeshData;
use crate::files::{FileError, write_file_with};
use std::io::{self, Write};
use std::path::Path;

/// Writes a mesh as binary little-endian PLY, which [`read_ply`](super::read_ply) and Mitsuba read.
///
/// # Errors
/// With the reason why it cannot be written; a file that was there stays as it was.
pub fn write_ply(mesh: &MeshData, path: &Path) -> Result<(), FileError> {
    write_file_with(path, |file| write(mesh, file))
}

pub(super) fn write(mesh: &MeshData, mut out: impl Write) -> io::Result<()> {
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.positions.len())?;
    let mut names = vec!["x", "y", "z"];
    names.extend(["nx", "ny", "nz"].into_iter().filter(|_| mesh.normals.is_some()));
    names.extend(["u", "v"].into_iter().filter(|_| mesh.uvs.is_some()));
    for name in names {
        writeln!(out, "property float {name}")?;
    }
    writeln!(
        out,
        "element face {}\nproperty list uchar uint vertex_indices\nend_header",
        mesh.triangles.len()
    )?;

    for (vertex, position) in mesh.positions.iter().enumerate() {
        let normal = mesh.normals.iter().flat_map(|normals| &normals[vertex]);
        let uv = mesh.uvs.iter().flat_map(|uvs| &uvs[vertex]);
        for number in position.iter().chain(normal).chain(uv) {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for vertex in triangle {
            out.write_all(&vertex.to_le_bytes())?;
        }
    }
    out.flush()
}
