//! Traces recorded rays on request, with one thread, and prints the time.

use crate::file::{read_mesh, read_rays};
use crate::record::replayed;
use etalon::math::{Ray, Transform};
use etalon::shape::accel::Accel;
use etalon::shape::mesh_data::MeshData;
use etalon::shape::{Geometry, Hit, Mesh, Normals};
use std::collections::BTreeMap;
use std::error::Error;
use std::io::{BufRead, Write};
use std::path::Path;
use std::time::Instant;

/// Answers the requests on standard input about one mesh.
pub fn replay(folder: &Path, name: &str) -> Result<(), Box<dyn Error>> {
    let soup = read_mesh(&folder.join(format!("{name}.mesh")))?;
    let data = MeshData { positions: soup.positions, triangles: soup.triangles, ..MeshData::default() };
    let mesh = Geometry::Mesh(Mesh::new(data, &Transform::IDENTITY, Normals::OF_FACES));
    let start = Instant::now();
    let accel = Accel::new(&[&mesh]);
    println!(
        r#"{{"triangles": {}, "build_seconds": {}, "bytes": {}, "nodes": {}}}"#,
        mesh.primitives(),
        start.elapsed().as_secs_f64(),
        accel.bytes(),
        accel.node_count(),
    );
    let mut sets: BTreeMap<String, Vec<Ray>> = BTreeMap::new();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let (Some(question), Some(kind)) = (words.first(), words.get(1)) else {
            return Err(format!("`{line}` has fewer than two words").into());
        };
        if !sets.contains_key(*kind) {
            let rays = read_rays(&folder.join(format!("{name}-{kind}.rays")))?;
            sets.insert(kind.to_string(), rays.iter().map(replayed).collect());
        }
        let rays = &sets[*kind];
        let start = Instant::now();
        let met = match *question {
            "occluded" => rays.iter().filter(|ray| accel.occluded(ray)).count(),
            _ => rays.iter().filter(|ray| accel.closest(ray).is_some()).count(),
        };
        let seconds = start.elapsed().as_secs_f64();
        println!(r#"{{"seconds": {seconds}, "rays": {}, "met": {met}}}"#, rays.len());
        if let ("hits", Some(path)) = (*question, words.get(2)) {
            write_hits(Path::new(path), rays.iter().map(|ray| accel.closest(ray)))?;
        }
    }
    Ok(())
}

/// Writes for each ray the distance (`f64`; infinite without a hit) and the triangle (`u64`).
fn write_hits(path: &Path, hits: impl Iterator<Item = Option<Hit>>) -> std::io::Result<()> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    for hit in hits {
        let (t, primitive) = hit.map_or((f64::INFINITY, u64::MAX), |hit| (hit.t, u64::from(hit.primitive)));
        file.write_all(&t.to_le_bytes())?;
        file.write_all(&primitive.to_le_bytes())?;
    }
    file.flush()
}
