//! Writing PLY, for meshes that programs make.

use super::super::MeshData;
use std::{
    fs,
    io::{self, BufWriter, Write},
    path::Path,
};

/// Writes a mesh as binary little-endian PLY, which [`read_ply`](super::read_ply) and Mitsuba read.
///
/// The file appears whole or not at all: it is written beside its place under a name that ends in `.partial`
/// and then renamed.
///
/// # Errors
/// What the file system reports; a partial file is then removed.
pub fn write_ply(mesh: &MeshData, path: &Path) -> io::Result<()> {
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    let written = fs::File::create(&partial)
        .and_then(|file| write(mesh, BufWriter::new(file)))
        .and_then(|()| fs::rename(&partial, path));
    if written.is_err() {
        // The first error is the one worth telling.
        let _ = fs::remove_file(&partial);
    }
    written
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
