//! Mitsuba's `serialized` format, versions 3 and 4: meshes compressed with zlib, several to a file, and at
//! its end a table of where each begins. All numbers are little-endian.

use super::{MeshData, MeshError, Place, open};
use flate2::bufread::ZlibDecoder;
use std::{
    io::{BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom},
    path::Path,
};

/// What each mesh of a file begins with.
const MAGIC: u16 = 0x041c;

const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const DOUBLE_PRECISION: u32 = 0x2000;

/// Reads mesh number `shape_index`, counted from 0, of a serialized file. Vertex colours are passed over.
///
/// # Errors
/// A file that cannot be read or is cut short, another format or version, no mesh of that number, numbers
/// that are not finite, indices out of range, and a mesh without triangles.
pub fn read_serialized(path: &Path, shape_index: u32) -> Result<MeshData, MeshError> {
    let (file, length) = open(path)?;
    parse(BufReader::new(file), length, shape_index)
}

fn parse(mut file: impl BufRead + Seek, length: u64, shape_index: u32) -> Result<MeshData, MeshError> {
    let version = read_header(&mut file, 0)?;
    let begin = if shape_index == 0 { 0 } else { offset_of(&mut file, length, shape_index, version)? };
    let version = read_header(&mut file, begin)?;
    let fail = |message: String| MeshError::new(Place::Byte(begin), message);

    let mut stream = Stream { data: ZlibDecoder::new(file), begin };
    let flags = u32::from_le_bytes(stream.array()?);
    if version == 4 {
        // The shape's name ends with a zero.
        while stream.array::<1>()? != [0] {}
    }
    let [vertices, triangles] = [stream.count()?, stream.count()?];
    let double = flags & DOUBLE_PRECISION != 0;
    let number = if double { 8 } else { 4 };
    let has = |flag: u32| flags & flag != 0;
    let numbers =
        3 + 3 * u64::from(has(HAS_NORMALS)) + 2 * u64::from(has(HAS_UVS)) + 3 * u64::from(has(HAS_COLORS));
    let size = u128::from(vertices) * u128::from(numbers * number) + u128::from(triangles) * 12;
    if size > u128::from(length.saturating_sub(begin)) * DEFLATE_LIMIT || vertices > u64::from(u32::MAX) {
        return Err(fail(format!(
            "a mesh of {vertices} vertices and {triangles} triangles cannot be in this file"
        )));
    }

    let positions = stream.floats(vertices, double)?;
    let normals = if has(HAS_NORMALS) { Some(stream.floats(vertices, double)?) } else { None };
    let uvs = if has(HAS_UVS) { Some(stream.floats(vertices, double)?) } else { None };
    if has(HAS_COLORS) {
        stream.skip(vertices * 3 * number)?;
    }
    let triangles = stream.records(triangles, u32::from_le_bytes)?;
    if triangles.is_empty() {
        return Err(fail("the mesh has no triangles".into()));
    }
    if let Some(vertex) = triangles.iter().flatten().find(|vertex| u64::from(**vertex) >= vertices) {
        return Err(fail(format!("a triangle asks for vertex {vertex} of {vertices}")));
    }
    Ok(MeshData { positions, normals, uvs, triangles, attributes: None })
}

/// Deflate cannot make data smaller than this many times (zlib's "Technical Details": 1032 to 1).
const DEFLATE_LIMIT: u128 = 1032;

/// Checks that a mesh begins at byte `begin`, and tells its version.
fn read_header(file: &mut (impl Read + Seek), begin: u64) -> Result<u16, MeshError> {
    let fail = |message: String| MeshError::new(Place::Byte(begin), message);
    let read = |error: std::io::Error| match error.kind() {
        ErrorKind::UnexpectedEof => fail("the file ends where a serialized mesh should begin".into()),
        _ => fail(format!("cannot read the file: {error}")),
    };
    let mut header = [0; 4];
    file.seek(SeekFrom::Start(begin)).map_err(read)?;
    file.read_exact(&mut header).map_err(read)?;
    let [m0, m1, v0, v1] = header;
    if u16::from_le_bytes([m0, m1]) != MAGIC {
        return Err(fail("no serialized mesh begins here".into()));
    }
    match u16::from_le_bytes([v0, v1]) {
        version @ (3 | 4) => Ok(version),
        version => Err(fail(format!("serialized version {version}; versions 3 and 4 can be read"))),
    }
}

/// Where mesh `index` begins, by the table at the end of the file: an offset for each mesh, of four bytes in
/// version 3 and eight in version 4, and then their number.
fn offset_of(file: &mut (impl Read + Seek), length: u64, index: u32, version: u16) -> Result<u64, MeshError> {
    let read = |error: std::io::Error| MeshError::file(format!("cannot read the table of meshes: {error}"));
    let mut count = [0; 4];
    file.seek(SeekFrom::Start(length.saturating_sub(4))).map_err(read)?;
    file.read_exact(&mut count).map_err(read)?;
    let count = u32::from_le_bytes(count);
    if index >= count {
        return Err(MeshError::file(format!(
            "there is no mesh {index}: the file holds {count}, counted from 0"
        )));
    }
    let width = if version == 3 { 4 } else { 8 };
    let entry = (length - 4)
        .checked_sub(u64::from(count - index) * width)
        .ok_or_else(|| MeshError::file(format!("a table of {count} meshes does not fit in the file")))?;
    let mut offset = [0; 8];
    file.seek(SeekFrom::Start(entry)).map_err(read)?;
    file.read_exact(&mut offset[..width as usize]).map_err(read)?;
    let offset = u64::from_le_bytes(offset);
    if offset >= length {
        return Err(MeshError::new(
            Place::Byte(entry),
            format!("mesh {index} would begin past the file's end"),
        ));
    }
    Ok(offset)
}

/// The decompressed contents of the mesh that begins at byte `begin`.
struct Stream<R> {
    data: ZlibDecoder<R>,
    begin: u64,
}

impl<R: BufRead> Stream<R> {
    fn fail(&self, message: impl Into<String>) -> MeshError {
        MeshError::new(Place::Byte(self.begin), message)
    }

    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), MeshError> {
        self.data.read_exact(buffer).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => self.fail("the mesh that begins here ends too early"),
            _ => self.fail(format!("the mesh that begins here cannot be decompressed: {error}")),
        })
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], MeshError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn count(&mut self) -> Result<u64, MeshError> {
        self.array().map(u64::from_le_bytes)
    }

    fn skip(&mut self, bytes: u64) -> Result<(), MeshError> {
        match std::io::copy(&mut self.data.by_ref().take(bytes), &mut std::io::sink()) {
            Ok(skipped) if skipped == bytes => Ok(()),
            _ => Err(self.fail("the mesh that begins here ends too early")),
        }
    }

    /// Records of `N` numbers. Memory grows with what has been decompressed, not with what was promised.
    fn records<const N: usize, const SIZE: usize, T: Copy + Default>(
        &mut self,
        count: u64,
        number: impl Fn([u8; SIZE]) -> T,
    ) -> Result<Vec<[T; N]>, MeshError> {
        const RECORDS: usize = 4096;
        let mut buffer = vec![0; RECORDS * N * SIZE];
        let mut records = Vec::new();
        let mut left = count;
        while left > 0 {
            let batch = left.min(RECORDS as u64) as usize;
            let bytes = &mut buffer[..batch * N * SIZE];
            self.fill(bytes)?;
            let (numbers, _) = bytes.as_chunks::<SIZE>();
            let (chunks, _) = numbers.as_chunks::<N>();
            records.extend(chunks.iter().map(|chunk| chunk.map(&number)));
            left -= batch as u64;
        }
        Ok(records)
    }

    fn floats<const N: usize>(&mut self, count: u64, double: bool) -> Result<Vec<[f32; N]>, MeshError> {
        let records: Vec<[f32; N]> = if double {
            self.records(count, |bytes| f64::from_le_bytes(bytes) as f32)?
        } else {
            self.records(count, f32::from_le_bytes)?
        };
        if !records.iter().flatten().all(|number| number.is_finite()) {
            return Err(self.fail("the mesh that begins here has an infinite number or none (NaN)"));
        }
        Ok(records)
    }
}

#[cfg(test)]
mod tests;
