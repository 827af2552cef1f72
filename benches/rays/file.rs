//! The file formats that the programs exchange: little-endian numbers of four bytes, so that a reader takes
//! three lines in any language.
//!
//! `.mesh`: the numbers of vertices and triangles, then x y z of each vertex (`f32`) and three indices per
//! triangle (`u32`). `.rays`: for each ray its origin, the distance where it starts, its direction and the
//! distance where it ends (`f32`).

use std::io::{self, Write};
use std::path::Path;

/// Vertices and triangles, without attributes that do not matter for intersection.
#[derive(Default)]
pub struct Soup {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

/// A ray: origin, start, direction, end.
pub type RayRecord = [f32; 8];

pub fn write_mesh(path: &Path, soup: &Soup) -> io::Result<()> {
    let mut file = io::BufWriter::new(std::fs::File::create(path)?);
    for count in [soup.positions.len(), soup.triangles.len()] {
        file.write_all(&(count as u32).to_le_bytes())?;
    }
    for number in soup.positions.iter().flatten() {
        file.write_all(&number.to_le_bytes())?;
    }
    for index in soup.triangles.iter().flatten() {
        file.write_all(&index.to_le_bytes())?;
    }
    file.flush()
}

pub fn write_rays(path: &Path, rays: &[RayRecord]) -> io::Result<()> {
    let mut file = io::BufWriter::new(std::fs::File::create(path)?);
    for number in rays.iter().flatten() {
        file.write_all(&number.to_le_bytes())?;
    }
    file.flush()
}

fn words(path: &Path) -> io::Result<Vec<u32>> {
    let bytes = std::fs::read(path)?;
    Ok(bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
}

pub fn read_mesh(path: &Path) -> io::Result<Soup> {
    let words = words(path)?;
    let (counts, rest) = words.split_at_checked(2).ok_or(io::ErrorKind::UnexpectedEof)?;
    let (positions, triangles) =
        rest.split_at_checked(3 * counts[0] as usize).ok_or(io::ErrorKind::UnexpectedEof)?;
    let positions = positions.as_chunks::<3>().0.iter().map(|p| p.map(f32::from_bits)).collect();
    Ok(Soup { positions, triangles: triangles.as_chunks::<3>().0.to_vec() })
}

pub fn read_rays(path: &Path) -> io::Result<Vec<RayRecord>> {
    Ok(words(path)?.as_chunks::<8>().0.iter().map(|ray| ray.map(f32::from_bits)).collect())
}
