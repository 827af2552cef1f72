//! Wavefront OBJ: lines of text, with indices of their own for positions, texture coordinates and normals.
//!
//! Read are `v`, `vt`, `vn` and `f`; all else (groups, materials, lines, curves) is passed over.

use super::{MeshData, MeshError, read_bytes, vertex_number};
use crate::spelling::shortened;
use std::{collections::HashMap, path::Path};

/// Reads an OBJ mesh, with polygons cut into fans of triangles (right for convex ones).
///
/// `flip_tex_coords`, by default true in Mitsuba, replaces v by 1 − v. Negative indices count back from the
/// last value read. A corner without a normal or texture coordinate in a file that has some gets zeros; 0 is
/// the index of none. Normals and texture coordinates may come after the faces that ask for them.
///
/// # Errors
/// A file that cannot be read, a line that cannot be understood, numbers that are not finite, an index of
/// nothing or of a position that comes later, and a file without triangles.
pub fn read_obj(path: &Path, flip_tex_coords: bool) -> Result<MeshData, MeshError> {
    let bytes = read_bytes(path)?;
    // A byte-order mark is no part of the first keyword.
    parse(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes), flip_tex_coords)
}

/// The index of an attribute that a face does not give.
const MISSING: u32 = u32::MAX;

/// The value tables of the file, and the mesh that its faces pick from them.
#[derive(Default)]
struct Reader {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    vertices: Vertices,
    triangles: Vec<[u32; 3]>,
    /// Where the line begins that is being read.
    at: usize,
    /// Of texture coordinates and normals that had not come when a face asked for them, the last in their
    /// table, and where that face is.
    awaited: [Option<(u32, usize)>; 2],
}

/// The attributes that a corner has indices of.
const ATTRIBUTES: [&str; 3] = ["position", "texture coordinate", "normal"];

fn parse(bytes: &[u8], flip_tex_coords: bool) -> Result<MeshData, MeshError> {
    let mut reader = Reader::default();
    let mut face = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let length = line_length(&bytes[at..]);
        let mut words = Words(&bytes[at..at + length]);
        reader.at = at;
        reader
            .line(&mut words, flip_tex_coords, &mut face)
            .map_err(|fault| MeshError::line(bytes, at, fault))?;
        at += length + 1;
    }
    reader.finish(bytes)
}

/// Bytes up to the end of a line, which goes on behind a backslash if it is one of numbers. In a comment that is a
/// letter like any other.
fn line_length(bytes: &[u8]) -> usize {
    let end_from = |begin: usize| {
        let rest = &bytes[begin..];
        begin + rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len())
    };
    let (mut begin, mut end) = (0, end_from(0));
    if !matches!(bytes[..end].trim_ascii_start().first(), Some(b'v' | b'f')) {
        return end;
    }
    let goes_on = |line: &[u8]| line.trim_ascii_end().ends_with(b"\\") && !line.contains(&b'#');
    while end < bytes.len() && goes_on(&bytes[begin..end]) {
        (begin, end) = (end + 1, end_from(end + 1));
    }
    end
}

impl Reader {
    fn line(&mut self, words: &mut Words, flip: bool, face: &mut Vec<[u32; 3]>) -> Result<(), String> {
        match words.next() {
            Some(b"v") => self.positions.push(words.numbers()?),
            Some(b"vn") => self.normals.push(words.numbers()?),
            Some(b"vt") => {
                let [u, v] = words.numbers()?;
                self.uvs.push([u, if flip { 1.0 - v } else { v }]);
            }
            Some(b"f") => {
                face.clear();
                while let Some(word) = words.next().filter(|word| word[0] != b'#') {
                    face.push(self.corner(word)?);
                }
                // As in Mitsuba, what has no area is none.
                if face.len() >= 3 {
                    self.face(face)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// One corner of a face: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, word: &[u8]) -> Result<[u32; 3], String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut corner = [MISSING; 3];
        let mut parts = word.split(|&byte| byte == b'/');
        for (attribute, (slot, count)) in corner.iter_mut().zip(counts).enumerate() {
            let Some(part) = parts.next().filter(|part| !part.is_empty()) else { continue };
            let index = integer(part).ok_or_else(|| format!("`{}` is no corner of a face", quoted(word)))?;
            if index == 0 && attribute > 0 {
                continue;
            }
            // Counted from 1, or back from the end.
            let resolved = if index > 0 { index - 1 } else { index + count as i64 };
            *slot = match u32::try_from(resolved) {
                Ok(value) if index != 0 && (value as usize) < count => value,
                Ok(value) if index > 0 && attribute > 0 && value != MISSING => {
                    let awaited = &mut self.awaited[attribute - 1];
                    if awaited.is_none_or(|(last, _)| last < value) {
                        *awaited = Some((value, self.at));
                    }
                    value
                }
                _ => {
                    let what = ATTRIBUTES[attribute];
                    return Err(format!("a face asks for {what} {index}; {count} came before it"));
                }
            };
        }
        if corner[0] == MISSING || parts.next().is_some() {
            return Err(format!("`{}` is no corner of a face", quoted(word)));
        }
        Ok(corner)
    }

    fn face(&mut self, corners: &[[u32; 3]]) -> Result<(), String> {
        let mut fan = corners.iter().map(|corner| self.vertices.number(*corner));
        let (Some(first), Some(second)) = (fan.next(), fan.next()) else { return Ok(()) };
        let (first, mut previous) = (first?, second?);
        for next in fan {
            let next = next?;
            self.triangles.push([first, previous, next]);
            previous = next;
        }
        Ok(())
    }

    fn finish(self, bytes: &[u8]) -> Result<MeshData, MeshError> {
        let found = [self.uvs.len(), self.normals.len()];
        for (attribute, (awaited, count)) in self.awaited.into_iter().zip(found).enumerate() {
            if let Some((last, at)) = awaited.filter(|(last, _)| *last as usize >= count) {
                let (what, index) = (ATTRIBUTES[attribute + 1], u64::from(last) + 1);
                let message = format!("a face asks for {what} {index}; the file has {count}");
                return Err(MeshError::line(bytes, at, message));
            }
        }
        if self.triangles.is_empty() {
            return Err(MeshError::file("the mesh has no triangles"));
        }
        let corners = &self.vertices.corners;
        let has = |attribute: usize| corners.iter().any(|corner| corner[attribute] != MISSING);
        let uv = |corner: &[u32; 3]| self.uvs.get(corner[1] as usize).copied().unwrap_or_default();
        let normal = |corner: &[u32; 3]| self.normals.get(corner[2] as usize).copied().unwrap_or_default();
        Ok(MeshData {
            positions: corners.iter().map(|corner| self.positions[corner[0] as usize]).collect(),
            uvs: has(1).then(|| corners.iter().map(uv).collect()),
            normals: has(2).then(|| corners.iter().map(normal).collect()),
            triangles: self.triangles,
            attributes: None,
        })
    }
}

/// The distinct corners, each of which becomes a vertex, in the order of their first use.
#[derive(Default)]
struct Vertices {
    corners: Vec<[u32; 3]>,
    /// For each position its first vertex, or `MISSING`.
    first: Vec<u32>,
    /// The vertices that are not the first of their position. It is only ever asked, never walked through.
    further: HashMap<[u32; 3], u32>,
}

impl Vertices {
    fn number(&mut self, corner: [u32; 3]) -> Result<u32, String> {
        let next = vertex_number(self.corners.len()).map_err(|error| error.message)?;
        let position = corner[0] as usize;
        if position >= self.first.len() {
            self.first.resize(position + 1, MISSING);
        }
        let first = &mut self.first[position];
        if *first == MISSING {
            *first = next;
        } else if self.corners[*first as usize] == corner {
            return Ok(*first);
        } else {
            let number = *self.further.entry(corner).or_insert(next);
            if number != next {
                return Ok(number);
            }
        }
        self.corners.push(corner);
        Ok(next)
    }
}

/// The words of one line.
struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            let begin = self.0.iter().position(|byte| !byte.is_ascii_whitespace())?;
            let rest = &self.0[begin..];
            let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
            let (word, rest) = rest.split_at(length);
            self.0 = rest;
            // At the end of a line that goes on.
            let word = word.strip_suffix(b"\\").unwrap_or(word);
            if !word.is_empty() {
                return Some(word);
            }
        }
    }

    /// The first numbers of what is left, which may go on with others: a weight, a third texture coordinate,
    /// a colour.
    fn numbers<const N: usize>(&mut self) -> Result<[f32; N], String> {
        let mut numbers = [0.0; N];
        for value in &mut numbers {
            *value = number(self.next().ok_or_else(|| format!("{N} numbers are wanted"))?)?;
        }
        while let Some(word) = self.next().filter(|word| word[0] != b'#') {
            number(word)?;
        }
        Ok(numbers)
    }
}

fn number(word: &[u8]) -> Result<f32, String> {
    let parsed = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f32>().ok());
    let finite = parsed.filter(|number| number.is_finite());
    finite.ok_or_else(|| format!("`{}` is not a finite number", quoted(word)))
}

fn integer(digits: &[u8]) -> Option<i64> {
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// The beginning of a word, fit for an error message.
fn quoted(word: &[u8]) -> String {
    const MOST: usize = 256;
    shortened(&String::from_utf8_lossy(&word[..word.len().min(MOST)]))
}

#[cfg(test)]
mod tests {
    use super::{super::Place, super::tests::assert_valid, *};
    use proptest::prelude::*;

    const CORNER_OF_A_BOX: &str = "# two squares that share an edge, but not its texture coordinates\n\
        o box\r\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\n\tv  0 1 0\nv 1 0 -1\nv 1 1 -1\nv 9 9 9\n\
        vt 0 0\nvt 1 0.25\nvt 1 1 0\nvt 0 1\n\
        usemtl red\nf 1/1 2/2 3/3 4/4\r\nf 2/1 5/2/ 6/3 -5/-1 # end";

    #[test]
    fn corners_become_vertices_once() {
        let mesh = parse(CORNER_OF_A_BOX.as_bytes(), true).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
        assert_eq!(mesh.positions[4..], [[1., 0., 0.], [1., 0., -1.], [1., 1., -1.], [1., 1., 0.]]);
        assert_eq!(mesh.uvs.as_ref().unwrap()[..4], [[0., 1.], [1., 0.75], [1., 0.], [0., 0.]]);
        assert_eq!(mesh.normals, None);
        assert_valid(&mesh);
        let upright = parse(CORNER_OF_A_BOX.as_bytes(), false).unwrap();
        assert_eq!(upright.uvs.unwrap()[..2], [[0., 0.], [1., 0.25]]);
    }

    #[test]
    fn lines_of_numbers_go_on_behind_a_backslash() {
        let text = b"# a folder\\\nv 0 0 \\\n 0\nv 1 0 0\r\nv 1 1 0\nv 0 1 0\nf 1 2\\\r\n3 \\\n4\nf 1 2 9";
        let error = parse(text, true).unwrap_err();
        assert_eq!((error.place, error.message.contains("position 9")), (Place::Line(10), true), "{error}");
        let mesh = parse(&text[..text.len() - 8], true).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!(parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1\\2 3", true).is_err());
        let commented = parse(b"v 0 0 0 # of a folder\\\nv 1 0 0\nv 0 1 0\nf 1 2 3", true).unwrap();
        assert_eq!(commented.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn a_corner_without_a_normal_gets_none() {
        let mesh = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nf 1//1 2 3//-1\nf 1//1 2 3", true).unwrap();
        assert_eq!(mesh.normals.unwrap(), [[0., 0., 2.], [0.; 3], [0., 0., 2.], [0.; 3]]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
        assert_eq!(mesh.uvs, None);
    }

    #[test]
    fn what_is_no_position_may_come_after_the_faces_and_0_is_none() {
        let mesh = parse(
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2/2/0 3/0/2\nvt 0 1\nvt 1 1\nvn 0 0 1\nvn 0 1 0",
            false,
        )
        .unwrap();
        assert_eq!(mesh.uvs.unwrap(), [[0., 1.], [1., 1.], [0.; 2]]);
        assert_eq!(mesh.normals.unwrap(), [[0., 0., 1.], [0.; 3], [0., 1., 0.]]);
    }

    #[test]
    fn faults_are_told_with_their_line() {
        for (text, place, message) in [
            ("v 0 0 0\nv 1 inf 0", Place::Line(2), "`inf` is not a finite number"),
            ("v 0 0 0\n\nv 1 0", Place::Line(3), "3 numbers are wanted"),
            ("v 0 0 0\nvt 1 x", Place::Line(2), "`x` is not a finite number"),
            ("v 0 0 0\nf 1 1 2", Place::Line(2), "a face asks for position 2; 1 came before it"),
            ("v 0 0 0\nf 1 1 0", Place::Line(2), "a face asks for position 0; 1 came before it"),
            ("v 0 0 0\nf 1 1 -2", Place::Line(2), "a face asks for position -2; 1 came before it"),
            ("v 0 0 0\nf 1 1/1 1", Place::Line(2), "a face asks for texture coordinate 1; the file has 0"),
            (
                "v 0 0 0\nf 1 1 1\nf 1//2 1//3 1\nvn 0 0 1",
                Place::Line(3),
                "a face asks for normal 3; the file has 1",
            ),
            ("v 0 0 0\nf 1 1 1//-1", Place::Line(2), "a face asks for normal -1; 0 came before it"),
            ("v 0 0 0\nf 1 1 1/////1", Place::Line(2), "`1/////1` is no corner of a face"),
            ("v 0 0 0\nf 1 1 /1", Place::Line(2), "`/1` is no corner of a face"),
            (
                "v 0 0 0\nf 1 1 99999999999999999999",
                Place::Line(2),
                "`99999999999999999999` is no corner of a face",
            ),
            ("v 0 0 0\nv 1 0 0 1 nan", Place::Line(2), "`nan` is not a finite number"),
            ("v 0 0 0\nf 1 1\n", Place::File, "the mesh has no triangles"),
            ("v 0 0 0\n", Place::File, "the mesh has no triangles"),
            ("", Place::File, "the mesh has no triangles"),
        ] {
            let error = parse(text.as_bytes(), true).unwrap_err();
            assert_eq!((error.place, error.message.as_str()), (place, message), "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn lines_of_any_kind_give_an_error_or_a_valid_mesh(
            lines in prop::collection::vec("(v|vt|vn|f|g|#)( -?[0-9]{1,2}(/[0-9]?){0,2}){0,4}", 0..30),
        ) {
            let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", lines.join("\n"));
            if let Ok(mesh) = parse(text.as_bytes(), true) {
                assert_valid(&mesh);
            }
        }

        #[test]
        fn a_cut_or_altered_file_gives_an_error_or_a_valid_mesh(
            cut in any::<prop::sample::Index>(), at in any::<prop::sample::Index>(), byte: u8,
        ) {
            let mut bytes = CORNER_OF_A_BOX.as_bytes().to_vec();
            if let Ok(mesh) = parse(&bytes[..cut.index(bytes.len())], true) {
                assert_valid(&mesh);
            }
            let at = at.index(bytes.len());
            bytes[at] = byte;
            if let Ok(mesh) = parse(&bytes, true) {
                assert_valid(&mesh);
            }
        }

        #[test]
        fn random_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(parse(&bytes, true).is_err());
        }
    }
}
