//! What a shaft calls clear, asked of rays.

use super::*;
use crate::math::random::{direction, uniform};
use crate::math::{DVec2, Ray, Transform, length};
use crate::shape::mesh_data::MeshData;
use crate::shape::{Cube, Cylinder, Geometry, Mesh, Normals, Patch, Sphere, patch::Outline};
use rand_pcg::Pcg32;

/// Patches and balls, a primitive each; then cubes, cylinders and a mesh of single triangles: somewhere in a
/// cube.
fn clutter(rng: &mut Pcg32, count: usize) -> Vec<Geometry> {
    let mut data = MeshData::default();
    let (mut shapes, mut others) = (vec![], vec![]);
    for i in 0..count {
        let at = DVec3::new(uniform(rng), uniform(rng), uniform(rng)) * 4.0;
        let axis = direction(rng);
        let size = Transform::scale(DVec3::splat(0.1 + 0.4 * uniform(rng))).unwrap();
        let turn = Transform::rotate(axis, 360.0 * uniform(rng)).unwrap();
        let place = Transform::translate(at).after(&turn).after(&size);
        if i % 8 == 3 {
            others.push(Geometry::Cube(Cube::new(&place, false)));
        } else if i % 16 == 7 {
            others.push(Geometry::Cylinder(Cylinder::new(&place, DVec3::ZERO, DVec3::Z, 0.3, false)));
        }
        match i % 4 {
            0 => shapes.push(Geometry::Patch(Patch::new(&place, false, Outline::Square))),
            1 => shapes.push(Geometry::Sphere(Sphere::new(&place, DVec3::ZERO, 0.3, false))),
            2 => shapes.push(Geometry::Patch(Patch::new(&place, false, Outline::Circle))),
            _ => {
                let first = data.positions.len() as u32;
                let corners = [DVec3::X, DVec3::Y, -DVec3::X].map(|corner| place.point(corner));
                data.positions.extend(corners.map(|p| p.to_array().map(|x| x as f32)));
                data.triangles.push([first, first + 1, first + 2]);
            }
        }
    }
    shapes.extend(others);
    shapes.push(Geometry::Mesh(Mesh::new(data, &Transform::IDENTITY, Normals::OF_FACES)));
    shapes
}

/// A spot of a flat primitive, and the point that another is asked about: positions and primitives.
type Places = (Vec<DVec3>, u32, DVec3, u32);

fn places(rng: &mut Pcg32, shapes: &[Geometry]) -> Places {
    let mut pick = || {
        let shape = (uniform(rng) * shapes.len() as f64) as usize;
        (shape as u32, DVec2::new(uniform(rng), uniform(rng)))
    };
    let ((from, at), (to, there)) = (pick(), pick());
    let near = |i: u32| {
        let part = DVec2::new(f64::from(i % 4), f64::from(i / 4)) * 0.02;
        shapes[from as usize].sample_area::<false>(0.9 * at + part).p
    };
    ((0..16).map(near).collect(), from, shapes[to as usize].sample_area::<false>(there).p, to)
}

#[test]
fn what_is_clear_is_seen_by_all() {
    for count in [16, 24, 80, 300] {
        let mut rng = Pcg32::new(0, count as u64);
        let shapes = clutter(&mut rng, count);
        let accel = Accel::new(&shapes.iter().collect::<Vec<_>>());
        assert_eq!(accel.node_count() == 0, count < 40);
        let (mut shaft, mut clear, mut free) = (Shaft::default(), 0, 0);
        for _ in 0..10_000 {
            let (points, from, to, on) = places(&mut rng, &shapes[..count - count / 4]);
            // Inside of a ball, and behind what one lies on, nothing is asked about.
            let round = |shape: u32| matches!(shapes[shape as usize], Geometry::Sphere(_));
            if from == on || round(from) || round(on) {
                continue;
            }
            shaft.begin(points.iter().copied());
            let sees = |p: &DVec3| {
                // A ray meets what it aims at early by its rounding over a small cosine.
                let end = length(to - *p) * (1.0 - 1e-9);
                !accel.occluded(&Ray::leaving(*p, (to - *p) / length(to - *p), end, from))
            };
            let all = points.iter().all(sees);
            free += u32::from(all);
            if accel.is_clear(&mut shaft, to, on) {
                clear += 1;
                assert!(all, "{points:?} {to}");
            }
        }
        assert!(clear > 100, "{clear} of {free} with {count}");
    }
}

#[test]
fn in_an_empty_room_everything_is_clear_and_a_needle_ends_that() {
    let wall = |axis: DVec3, angle: f64| {
        let turn = Transform::rotate(axis, angle).unwrap();
        Patch::new(&turn.after(&Transform::translate(-DVec3::Z)), false, Outline::Square)
    };
    let walls = [
        (DVec3::X, 0.0),
        (DVec3::X, 90.0),
        (DVec3::X, 180.0),
        (DVec3::X, 270.0),
        (DVec3::Y, 90.0),
        (DVec3::Y, 270.0),
    ];
    let mut shapes: Vec<Geometry> = walls.map(|(axis, angle)| Geometry::Patch(wall(axis, angle))).into();
    let mut rng = Pcg32::new(0, 1);
    let needle = MeshData {
        positions: vec![[0.0, 0.0, -0.3], [0.0, 1e-3, 0.3], [1e-3, 0.0, 0.3]],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    let mut shaft = Shaft::default();
    for with_needle in [false, true] {
        if with_needle {
            shapes.push(Geometry::Mesh(Mesh::new(needle.clone(), &Transform::IDENTITY, Normals::OF_FACES)));
        }
        let accel = Accel::new(&shapes.iter().collect::<Vec<_>>());
        let mut clear = [0; 2];
        for _ in 0..2000 {
            let (points, from, to, on) = places(&mut rng, &shapes[..6]);
            if from != on {
                shaft.begin(points.into_iter());
                clear[usize::from(accel.is_clear(&mut shaft, to, on))] += 1;
            }
        }
        assert_eq!(clear[0] > 0, with_needle, "{clear:?}");
        assert!(clear[1] > 1000, "{clear:?}");
        if with_needle {
            shaft.begin([DVec3::new(-1.0, 0.01, 0.0), DVec3::new(-1.0, -0.01, 0.0)].into_iter());
            assert!(!accel.is_clear(&mut shaft, DVec3::new(1.0, 0.0, 0.0), 0));
        }
    }
}
