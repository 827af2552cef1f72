//! The rays that a path tracer with one bounce traces, found with Etalon's own tree.

use crate::file::{RayRecord, write_mesh, write_rays};
use crate::meshes::Subject;
use etalon::math::frame::unit;
use etalon::math::{DVec2, DVec3, Frame, Ray, Transform, length, warp};
use etalon::sampler::{Sampler, SamplerKind};
use etalon::shape::accel::Accel;
use etalon::shape::mesh_data::MeshData;
use etalon::shape::{Geometry, Mesh, Normals};
use std::error::Error;
use std::path::Path;

/// Number of rays along each side of the picture.
const SIDE: u32 = 512;

/// Writes a mesh and its rays: *primary* rays from a pinhole in row-major order, *shadow* rays from their
/// hits to a square lamp, and *bounce* rays from these hits in a cosine-distributed direction.
pub fn record(folder: &Path, name: &str, subject: &Subject) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    write_mesh(&folder.join(format!("{name}.mesh")), &subject.soup)?;
    let mesh = Geometry::Mesh(Mesh::new(
        MeshData {
            positions: subject.soup.positions.clone(),
            triangles: subject.soup.triangles.clone(),
            ..MeshData::default()
        },
        &Transform::IDENTITY,
        Normals::OF_FACES,
    ));
    let accel = Accel::new(&[&mesh]);
    let (lo, hi) = mesh.bounds();
    // An offset against self-hits. Etalon excludes the primitive that a ray leaves instead, which other ray
    // tracers do not.
    let start = 1e-4 * (hi - lo).max_element();

    let camera = Frame::about(unit(subject.target - subject.eye));
    let [mut primary, mut shadow, mut bounce] = [const { Vec::new() }; 3];
    for pixel in 0..SIDE * SIDE {
        let (x, y) = (pixel % SIDE, pixel / SIDE);
        let u = Sampler::new(SamplerKind::Independent, 1, (x, y), 0).block(0);
        let u: [f64; 6] = std::array::from_fn(|i| u.one(i));
        let film = DVec2::new(x as f64 + u[0], y as f64 + u[1]) / SIDE as f64 - 0.5;
        let direction = unit(camera.to_world(DVec3::new(film.x, film.y, 0.6)));
        primary.push(ray(subject.eye, direction, 0.0, f64::INFINITY));
        let Some(hit) = accel.closest(&replayed(primary.last().expect("one was just added"))) else {
            continue;
        };
        let point = mesh.point::<false>(&Ray::free(subject.eye, direction), &hit, hit.primitive);
        let ng = if point.ng.dot(direction) > 0.0 { -point.ng } else { point.ng };
        let lamp = subject.light + DVec3::new(u[2] - 0.5, 0.0, u[3] - 0.5);
        let distance = length(lamp - point.p);
        let to_lamp = (lamp - point.p) / distance;
        if to_lamp.dot(ng) > 0.0 {
            shadow.push(ray(point.p, to_lamp, start, distance - start));
        }
        let onward = Frame::about(ng).to_world(warp::cosine_hemisphere(DVec2::new(u[4], u[5])));
        bounce.push(ray(point.p, onward, start, f64::INFINITY));
    }
    for (kind, rays) in [("primary", primary), ("shadow", shadow), ("bounce", bounce)] {
        write_rays(&folder.join(format!("{name}-{kind}.rays")), &rays)?;
    }
    Ok(())
}

fn ray(origin: DVec3, direction: DVec3, start: f64, end: f64) -> RayRecord {
    let ([a, b, c], [x, y, z]) = (origin.to_array(), direction.to_array());
    [a, b, c, start, x, y, z, end].map(|v| v as f32)
}

/// The ray of a record.
pub fn replayed(record: &RayRecord) -> Ray {
    let [a, b, c, start, x, y, z, end] = record.map(f64::from);
    Ray { start, end, ..Ray::free(DVec3::new(a, b, c), DVec3::new(x, y, z)) }
}
