//! Triangle meshes as their files hold them.
//!
//! Each reader is one file: it takes a path, and reads the whole mesh into plain arrays or returns a
//! [`MeshError`] that names the line or byte at fault. What a file claims about its own size is checked
//! against the bytes that are there before anything is allocated, so a broken file costs an error and nothing
//! else.
//!
//! The conventions are those of Mitsuba 3's `ply`, `obj` and `serialized` plugins, so a scene gives the same
//! surface in both. To add a format, write `format.rs` with a `read_format` and re-export it here.

mod obj;
mod ply;
mod procedural;
mod serialized;

pub use obj::read_obj;
pub use ply::{Answer, Attribute, AttributeFile, read_ply, write_ply};
pub use procedural::sea_urchin;
pub use serialized::read_serialized;

use std::{fmt, fs, path::Path};

/// A triangle mesh as a file holds it: object space, before any transform.
///
/// What the readers promise: at least one triangle, every index in range, every number finite, and `normals`
/// and `uvs` as long as `positions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// One point per vertex, in the file's own unit of length.
    pub positions: Vec<[f32; 3]>,
    /// One shading normal per vertex, of whatever length the file gives; the zero vector where it gives none.
    pub normals: Option<Vec<[f32; 3]>>,
    /// One texture coordinate per vertex.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Three vertex numbers per triangle, counterclockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Where attributes of vertices and triangles can be asked for, if the format has them.
    pub attributes: Option<AttributeFile>,
}

impl MeshData {
    /// The mesh with v replaced by 1 − v, should `flip` ask for it: the parameter `flip_tex_coords` of the
    /// formats that do not flip by themselves.
    pub fn with_flipped_texture(mut self, flip: bool) -> Self {
        for [_, v] in self.uvs.iter_mut().flatten().filter(|_| flip) {
            *v = 1.0 - *v;
        }
        self
    }
}

/// Where in a mesh file something was found wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A byte of a binary file, counted from 0.
    Byte(u64),
}

/// What was wrong with a mesh file, and where in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshError {
    /// The fault, and what was expected instead.
    pub message: String,
    /// Where it is.
    pub place: Place,
}

impl MeshError {
    fn new(place: Place, message: impl Into<String>) -> Self {
        Self { message: message.into(), place }
    }

    fn file(message: impl Into<String>) -> Self {
        Self::new(Place::File, message)
    }

    /// The place is the line that holds byte `at` of `text`.
    fn line(text: &[u8], at: usize, message: impl Into<String>) -> Self {
        let before = text.iter().take(at).filter(|&&byte| byte == b'\n').count();
        Self::new(Place::Line(before + 1), message)
    }
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::File => write!(f, "{}", self.message),
            Place::Line(line) => write!(f, "line {line}: {}", self.message),
            Place::Byte(byte) => write!(f, "byte {byte}: {}", self.message),
        }
    }
}

impl std::error::Error for MeshError {}

/// Opens a regular file; a device or pipe could go on for ever.
fn open(path: &Path) -> Result<(fs::File, u64), MeshError> {
    let unreadable = |error: std::io::Error| MeshError::file(format!("cannot read the file: {error}"));
    let file = fs::File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(MeshError::file("not a regular file"));
    }
    Ok((file, metadata.len()))
}

/// The bytes of a whole file.
fn read_bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    open(path)?;
    fs::read(path).map_err(|error| MeshError::file(format!("cannot read the file: {error}")))
}

/// The number a vertex gets, as triangles store it.
fn vertex_number(count: usize) -> Result<u32, MeshError> {
    u32::try_from(count).map_err(|_| MeshError::file("more than 2³² vertices"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What every reader promises of a mesh it returns.
    pub(super) fn assert_valid(mesh: &MeshData) {
        let count = mesh.positions.len();
        assert!(!mesh.triangles.is_empty());
        assert!(mesh.triangles.iter().flatten().all(|&vertex| (vertex as usize) < count));
        assert!(mesh.positions.iter().flatten().all(|number| number.is_finite()));
        if let Some(normals) = &mesh.normals {
            assert_eq!(normals.len(), count);
            assert!(normals.iter().flatten().all(|number| number.is_finite()));
        }
        if let Some(uvs) = &mesh.uvs {
            assert_eq!(uvs.len(), count);
            assert!(uvs.iter().flatten().all(|number| number.is_finite()));
        }
    }

    #[test]
    fn texture_coordinates_flip_when_asked() {
        let mesh = MeshData { uvs: Some(vec![[0.0, 0.25]]), ..MeshData::default() };
        assert_eq!(mesh.clone().with_flipped_texture(false), mesh);
        assert_eq!(mesh.with_flipped_texture(true).uvs, Some(vec![[0.0, 0.75]]));
    }

    #[test]
    fn an_error_says_where() {
        let error = MeshError::line(b"one\ntwo\nthree", 9, "odd");
        assert_eq!(error.place, Place::Line(3));
        assert_eq!(error.to_string(), "line 3: odd");
        assert_eq!(MeshError::new(Place::Byte(7), "odd").to_string(), "byte 7: odd");
    }

    #[test]
    fn what_is_not_a_file_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        assert_eq!(read_bytes(directory.path()).unwrap_err().place, Place::File);
        assert_eq!(read_bytes(&directory.path().join("absent")).unwrap_err().place, Place::File);
    }
}
