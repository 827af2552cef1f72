//! The tree against trying everything, and rays aimed where trees leak.

mod mixed;
mod vast;

use super::outside_choice::Limits;
use super::*;
use crate::math::frame::unit;
use crate::math::random::{direction, uniform};
use crate::math::ray::Ends;
use crate::math::{DVec3, Transform, length};
use crate::shape::mesh_data::MeshData;
use crate::shape::{Cube, Cylinder, Geometry, Mesh, Normals, Patch, Sphere, patch::Outline};
use glam::DVec2;
use rand_pcg::{Pcg32, rand_core::Rng};

/// A closed sphere of triangles.
fn ball(rings: u32, scale: f64, centre: DVec3) -> Geometry {
    let mut positions = vec![];
    let mut triangles = vec![];
    for i in 0..=rings {
        for j in 0..rings {
            let (sin, cos) = libm::sincos(std::f64::consts::PI * i as f64 / rings as f64);
            let (s, c) = libm::sincos(std::f64::consts::TAU * j as f64 / rings as f64);
            positions.push([sin * c, sin * s, cos].map(|v| v as f32));
            if i < rings {
                let (k, next) = (i * rings, (j + 1) % rings);
                triangles.push([k + j, k + rings + j, k + rings + next]);
                triangles.push([k + j, k + rings + next, k + next]);
            }
        }
    }
    let place = Transform::translate(centre).after(&Transform::scale(DVec3::splat(scale)).unwrap());
    Geometry::Mesh(Mesh::new(
        MeshData { positions, triangles, ..MeshData::default() },
        &place,
        Normals::OF_FACES,
    ))
}

/// So far from the origin, turned at random.
fn somewhere(rng: &mut Pcg32, distance: f64) -> Transform {
    Transform::translate(direction(rng) * distance)
        .after(&Transform::rotate(direction(rng), 360.0 * uniform(rng)).unwrap())
}

/// All kinds of shapes in turn, but no triangles.
fn of_kind(i: usize, place: &Transform) -> Geometry {
    match i % 5 {
        0 => Geometry::Patch(Patch::new(place, false, Outline::Square)),
        1 => Geometry::Patch(Patch::new(place, false, Outline::Circle)),
        2 => Geometry::Sphere(Sphere::new(place, DVec3::ZERO, 0.5, false)),
        3 => Geometry::Cube(Cube::new(place, false)),
        _ => Geometry::Cylinder(Cylinder::new(place, DVec3::ZERO, DVec3::Z, 0.3, false)),
    }
}

fn zoo() -> Vec<Geometry> {
    let mut rng = Pcg32::new(1, 1);
    let mut shapes = vec![ball(20, 1.0, DVec3::ZERO), ball(8, 0.3, DVec3::new(2.0, 0.0, 0.0))];
    for i in 0..40 {
        let place =
            somewhere(&mut rng, 3.0).after(&Transform::scale(DVec3::splat(0.1 + uniform(&mut rng))).unwrap());
        shapes.push(of_kind(i, &place));
    }
    shapes
}

const NONE_TRIED: Limits = Limits { all: 0, triangles: 0, beside: 0 };
const ALL_TRIED: Limits = Limits { all: usize::MAX, triangles: usize::MAX, beside: 0 };
/// Patches and spheres are tried, and triangles searched.
const BOTH: Limits = Limits { all: 0, triangles: 0, beside: usize::MAX };

#[test]
fn the_tree_finds_what_trying_everything_finds() {
    let shapes = zoo();
    let refs: Vec<&Geometry> = shapes.iter().collect();
    let [tree, flat, both] = [NONE_TRIED, ALL_TRIED, BOTH].map(|few| Accel::limited(&refs, vec![], few));
    assert!(tree.node_count() > 1 && flat.node_count() == 0 && both.node_count() > 1);
    assert!(
        tree.outside_tree.patches == 0 && flat.outside_tree.triangles > 0 && both.outside_tree.triangles == 0
    );
    assert!(both.outside_tree.patches > 0 && both.outside_tree.spheres > 0);
    let mut rng = Pcg32::new(2, 2);
    let mut hits = 0;
    for _ in 0..100_000 {
        let mut ray = Ray::free(direction(&mut rng) * 4.0 * uniform(&mut rng), direction(&mut rng));
        let found = tree.closest(&ray);
        for other in [&flat, &both] {
            assert_eq!(found, other.closest(&ray), "{ray:?}");
            assert_eq!(found.is_some(), other.occluded(&ray));
        }
        assert_eq!(found.is_some(), tree.occluded(&ray));
        if let Some(hit) = found {
            hits += 1;
            ray.end = hit.t;
            let onward = Ray::leaving(ray.at(hit.t), direction(&mut rng), f64::INFINITY, hit.primitive);
            for accel in [&tree, &flat, &both] {
                assert!(!accel.occluded(&ray));
                assert_eq!(tree.closest(&onward), accel.closest(&onward), "{onward:?}");
            }
        }
    }
    assert!(hits > 30_000, "{hits}");
}

/// Sticks in all directions, so thin that their triangles are cut before the tree is built.
fn twigs() -> Geometry {
    let mut rng = Pcg32::new(7, 7);
    let mut data = MeshData::default();
    for i in 0..300 {
        let (at, along) = (direction(&mut rng) * uniform(&mut rng), direction(&mut rng));
        let across = crate::math::Frame::about(along).s * 0.01;
        let corners = [at, at + along, at + across, at + along + across];
        data.positions.extend(corners.map(|p| p.to_array().map(|v| v as f32)));
        data.triangles.extend([[0, 1, 2], [2, 1, 3]].map(|t| t.map(|k| 4 * i + k)));
    }
    Geometry::Mesh(Mesh::new(data, &Transform::IDENTITY, Normals::OF_FACES))
}

#[test]
fn pieces_lead_to_whole_triangles() {
    let shape = twigs();
    let tree = Accel::new(&[&shape]);
    let flat = Accel::limited(&[&shape], vec![], ALL_TRIED);
    let stored: usize = tree.triangles.iter().map(Triangles::count).sum();
    assert!(stored > 650, "{stored}: nothing was cut");
    let mut rng = Pcg32::new(8, 8);
    let mut hits = 0;
    for _ in 0..100_000 {
        let ray = Ray::free(direction(&mut rng) * 2.0, direction(&mut rng));
        let found = tree.closest(&ray);
        assert_eq!(found, flat.closest(&ray), "{ray:?}");
        assert_eq!(found.is_some(), tree.occluded(&ray));
        hits += usize::from(found.is_some());
    }
    assert!(hits > 1_000, "{hits}");
}

#[test]
fn no_ray_leaks_through_edges_or_vertices() {
    for (scale, centre) in [(1.0, DVec3::ZERO), (1e-6, DVec3::ONE), (1e5, DVec3::new(1e6, -2e6, 3e5))] {
        let shape = ball(24, scale, centre);
        let accel = Accel::new(&[&shape]);
        let Geometry::Mesh(mesh) = &shape else { unreachable!() };
        let mut rng = Pcg32::new(3, 3);
        for i in 0..200_000usize {
            let triangle = mesh.triangles[i % mesh.triangles.len()];
            let corner = |k: usize| DVec3::from(mesh.positions[triangle[k] as usize].map(f64::from));
            let t = if i % 3 == 0 { 0.0 } else { uniform(&mut rng) };
            let target = corner(0) * (1.0 - t) + corner(i % 2 + 1) * t;
            let origin = centre + direction(&mut rng) * (0.5 * scale);
            let ray = Ray::free(origin, crate::math::frame::unit(target - origin));
            assert!(accel.closest(&ray).is_some(), "{ray:?} at scale {scale}");
        }
    }
}

#[test]
fn boxes_that_a_ray_just_touches_are_entered() {
    // Boxes without width, at points that the ray meets exactly: what its axes say differs by rounding alone.
    // None of them is 0.
    let space = Space::new((-DVec3::ONE, DVec3::ONE), 1.0);
    let mut rng = Pcg32::new(9, 9);
    for _ in 0..10_000 {
        let mut vector =
            || DVec3::from([0; 3].map(|_| f64::from(2 * (rng.next_u32() % 128) + 1) / 256.0 - 0.5));
        let (origin, way) = (vector(), vector());
        let ray = Ray::free(origin, way);
        let touched = space.local(origin + way).to_array().map(|v| v as f32);
        let mut node = Node::empty();
        node.set(5, touched, touched, node::NodeRef::node(1));
        let (entered, _) = node.intersect(&space.enter(&ray).unwrap());
        assert_eq!(entered, 1 << 5, "{ray:?}");
    }
}

#[test]
fn scaling_by_a_power_of_two_scales_every_hit_exactly() {
    for exponent in [-40, -13, 27, 40] {
        let factor = libm::scalbn(1.0, exponent);
        let (a, b) = (ball(16, 1.0, DVec3::ZERO), ball(16, factor, DVec3::ZERO));
        let (one, scaled) = (Accel::new(&[&a]), Accel::new(&[&b]));
        let mut rng = Pcg32::new(4, 4);
        for _ in 0..10_000 {
            let (o, d) = (direction(&mut rng) * 2.0, direction(&mut rng));
            let found = one.closest(&Ray::free(o, d));
            let expected = found.map(|hit| Hit { t: hit.t * factor, ..hit });
            assert_eq!(scaled.closest(&Ray::free(o * factor, d)), expected);
        }
    }
}

/// A room: six walls, a table top, two spheres, a cube and a column.
fn room() -> Vec<Geometry> {
    let wall = |axis: DVec3, angle: f64, at: DVec3| {
        let turn = Transform::rotate(axis, angle).unwrap();
        Geometry::Patch(Patch::new(&Transform::translate(at).after(&turn), false, Outline::Square))
    };
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let small = Transform::scale(DVec3::splat(0.3)).unwrap();
    vec![
        wall(x, 90.0, -y),
        wall(x, -90.0, y),
        wall(y, 90.0, -x),
        Geometry::Sphere(Sphere::new(&small, DVec3::new(1.0, 1.2, -0.4), 1.0, false)),
        wall(y, -90.0, x),
        wall(y, 180.0, z),
        wall(y, 0.0, -z),
        Geometry::Patch(Patch::new(&Transform::translate(y * 0.1).after(&small), false, Outline::Circle)),
        Geometry::Sphere(Sphere::new(&small, DVec3::new(-2.0, 1.0, 0.5), 0.7, true)),
        Geometry::Cube(Cube::new(&Transform::translate(DVec3::new(0.5, -0.8, 0.5)).after(&small), false)),
        Geometry::Cylinder(Cylinder::new(&small, DVec3::new(1.0, -1.0, 1.0), DVec3::Z, 0.3, false)),
    ]
}

#[test]
fn rays_together_meet_what_they_meet_alone() {
    let mut rng = Pcg32::new(5, 5);
    let (room, zoo) = (room(), zoo());
    let (small, large) = (&room[..], &zoo[..]);
    for (shapes, few, in_turns) in [
        (small, ALL_TRIED, false),
        (&room[..10], ALL_TRIED, false),
        (large, NONE_TRIED, false),
        (large, NONE_TRIED, true),
        (large, BOTH, false),
        (large, BOTH, true),
    ] {
        let shapes: Vec<&Geometry> = shapes.iter().collect();
        let mut accel = Accel::limited(&shapes, vec![], few);
        accel.scattered = in_turns;
        let mut ray = || {
            let origin = direction(&mut rng) * 0.9;
            let end = if uniform(&mut rng) < 0.5 { f64::INFINITY } else { uniform(&mut rng) };
            let from = (uniform(&mut rng) * 20.0) as u32;
            Ray::leaving(origin, direction(&mut rng), end, from)
        };
        for count in 0..200 {
            let rays: Vec<Ray> = (0..count % 13).map(|_| ray()).collect();
            let (mut hits, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
            accel.closest_all(&rays, &mut hits);
            accel.occluded_all(&rays, &mut occluded);
            for ((ray, hit), occluded) in rays.iter().zip(&hits).zip(&occluded) {
                assert_eq!(accel.closest(ray), *hit);
                assert_eq!(accel.occluded(ray), *occluded);
                assert_eq!(hit.is_some(), *occluded);
            }
        }
    }
}

/// Wherever a ray starts along its line, it meets what the line meets from there on.
#[test]
fn nothing_is_met_before_the_start() {
    let mut rng = Pcg32::new(8, 8);
    for shapes in [zoo(), room()] {
        let accel = Accel::new(&shapes.iter().collect::<Vec<_>>());
        let mut met = 0;
        for _ in 0..2000 {
            let line = Ray::free(direction(&mut rng) * 4.0, direction(&mut rng));
            let mut hits = vec![];
            let mut start = 0.0;
            while let Some(hit) = accel.closest(&Ray { start, ..line }) {
                assert!(hit.t > start, "{hit:?} from {start}");
                hits.push(hit);
                start = hit.t * (1.0 + 1e-9);
            }
            met += hits.len();
            for (i, after) in hits.iter().enumerate().skip(1) {
                let start = hits[i - 1].t + 0.5 * (after.t - hits[i - 1].t);
                assert_eq!(accel.closest(&Ray { start, ..line }), Some(*after));
                assert!(!accel.occluded(&Ray { start, end: start + 0.5 * (after.t - start), ..line }));
            }
        }
        assert!(met > 100, "{met}");
    }
}

#[test]
fn rays_take_turns_where_most_is_far() {
    let scattered = |shapes: &[Geometry]| Accel::new(&shapes.iter().collect::<Vec<_>>()).scattered;
    let fine = |size: f64| ball(300, size, DVec3::ZERO);
    assert!(scattered(&[fine(1.0)]));
    assert!(!scattered(&[ball(20, 1.0, DVec3::ZERO)]));
    assert!(!scattered(&[ball(20, 1.0, DVec3::ZERO), fine(0.01)]));
}

#[test]
fn walls_stand_in_nobodys_way_inside() {
    let room = room();
    let shapes: Vec<&Geometry> = room.iter().collect();
    let accel = Accel::new(&shapes);
    assert_eq!((accel.outside_tree.inner_patches, accel.patches.len()), (1, 3), "one table top, six walls");
    let mut rng = Pcg32::new(6, 6);
    let mut seen = [0; 2];
    for _ in 0..20_000 {
        let mut point = || {
            let shape = (uniform(&mut rng) * shapes.len() as f64) as usize;
            (
                shape as u32,
                shapes[shape].sample_area::<false>(DVec2::new(uniform(&mut rng), uniform(&mut rng))).p,
            )
        };
        let ((from, a), (to, b)) = (point(), point());
        let distance = length(b - a);
        // Along a wall that it ends on, a ray meets the wall early by its rounding over a small cosine.
        let end = distance * (1.0 - 1e-9);
        let ray = Ray::leaving(a, (b - a) / distance, end, from);
        if from == to {
            continue;
        }
        let inside = accel.occluded(&Ray { ends: Ends::OnSurfaces, ..ray });
        assert_eq!(inside, accel.occluded(&ray), "from {from} at {a} to {to} at {b}");
        seen[usize::from(inside)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 1000), "{seen:?}");
}

#[test]
fn spheres_are_met_from_inside_where_they_end() {
    let sphere = |x: f64| {
        Geometry::Sphere(Sphere::new(&Transform::translate(DVec3::new(x, 0.0, 0.0)), DVec3::ZERO, 0.5, false))
    };
    // One alone, and enough of them for a tree.
    for count in [1, 40] {
        let spheres: Vec<Geometry> = (0..count).map(|i| sphere(2.0 * f64::from(i))).collect();
        let accel = Accel::new(&spheres.iter().collect::<Vec<_>>());
        for i in 0..count {
            let origin = DVec3::new(2.0 * f64::from(i) + 0.25, 0.0, 0.0);
            for (towards, t) in [(DVec3::X, 0.25), (-DVec3::X, 0.75)] {
                let hit = accel.closest(&Ray::free(origin, towards)).unwrap();
                assert!(hit.primitive == i as u32 && (hit.t - t).abs() < 1e-12, "{i} of {count}: {hit:?}");
            }
        }
    }
}

#[test]
fn rays_that_leave_a_needle_do_not_meet_its_neighbour() {
    // Two faces a million times as long as wide, at a right angle along z.
    let w = 1e-5_f32;
    let data = MeshData {
        positions: vec![[-w, -w, -10.0], [w, -w, -10.0], [w, -w, 10.0], [w, w, 10.0]],
        triangles: vec![[0, 1, 2], [1, 3, 2]],
        ..MeshData::default()
    };
    let w = f64::from(w);
    let mesh = Geometry::Mesh(Mesh::new(data, &Transform::IDENTITY, Normals::OF_FACES));
    let accel = Accel::new(&[&mesh]);
    let mut rng = Pcg32::new(8, 8);
    for _ in 0..200_000 {
        // On the first face, a millionth to a hundred-millionth of its width from the edge, and farther from
        // it.
        let from_edge = w * libm::exp2(-20.0 - 7.0 * uniform(&mut rng));
        let place = |from_edge| DVec3::new(w - from_edge, -w, 18.0 * uniform(&mut rng) - 9.0);
        let [close, farther] = [from_edge, 4096.0 * from_edge].map(place);
        let [x, y, z] = direction(&mut rng).abs().to_array();
        let into = DVec3::new(x.max(y), x.min(y), z);
        let meets = |p, towards| accel.closest(&Ray::leaving(p, towards, f64::INFINITY, 0)).is_some();
        assert!(!meets(close, -into), "from {close} along {}", -into);
        assert!(meets(farther, into), "from {farther} along {into}");
    }
}

#[test]
fn of_surfaces_in_one_place_the_first_is_met() {
    let patch = || Geometry::Patch(Patch::new(&Transform::IDENTITY, false, Outline::Square));
    let triangle = || {
        let positions = vec![[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]];
        let data = MeshData { positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
        Geometry::Mesh(Mesh::new(data, &Transform::IDENTITY, Normals::OF_FACES))
    };
    let mut rng = Pcg32::new(5, 5);
    for count in [2, 7, 60] {
        let kinds: [Vec<Geometry>; 2] =
            [(0..count).map(|_| patch()).collect(), (0..count).map(|_| triangle()).collect()];
        for shapes in kinds {
            let accel = Accel::new(&shapes.iter().collect::<Vec<_>>());
            for _ in 0..100 {
                let to = DVec3::new(uniform(&mut rng) - 0.5, uniform(&mut rng) - 0.5, 0.0);
                let from = DVec3::new(0.0, 0.0, 2.0);
                let hit = accel.closest(&Ray::free(from, unit(to - from))).unwrap();
                assert_eq!(hit.primitive, 0, "of {count}");
            }
        }
    }
}
