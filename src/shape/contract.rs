//! Tests that every shape must pass, on every example of the registry that is a surface and on a smooth mesh.

use super::accel::Accel;
use super::mesh_data::MeshData;
use super::*;
use crate::scene::loader::Loader;
use crate::scene::params::Usage;
use crate::scene::registry::construct;
use crate::scene::xml;
use crate::spectrum::ColorMode;

/// A fan about the z axis with normals that are not its own and coordinates that shear.
fn fan() -> Geometry {
    let ring = [[1.0, 0.0, 0.0], [0.3, 1.1, 0.1], [-1.0, 0.2, -0.2], [-0.2, -0.9, 0.1]];
    let positions: Vec<[f32; 3]> = std::iter::once([0.1, 0.0, 0.4]).chain(ring).collect();
    let normals = positions.iter().map(|[x, y, _]| [0.4 * x, 0.3 * y, 1.0]).collect();
    let uvs = positions.iter().map(|[x, y, _]| [2.0 * x + 0.5 * y, 0.7 * y - 0.1 * x]).collect();
    let triangles = (0..4).map(|i| [0, 1 + i, 1 + (i + 1) % 4]).collect();
    let data = MeshData { positions, normals: Some(normals), uvs: Some(uvs), triangles, attributes: None };
    let mut mesh = Mesh::new(data, &Transform::IDENTITY, Normals::default());
    mesh.prepare_sampling();
    Geometry::Mesh(mesh)
}

/// Calls `f` with every surface.
fn each(mut f: impl FnMut(&str, &Geometry)) {
    for example in SHAPES.iter().flat_map(|entry| entry.examples) {
        let text = format!("<scene version=\"3.0.0\">{example}</scene>");
        let document = xml::read_text("example.xml", &text).unwrap();
        let loader = Loader::new(&document, ColorMode::Rgb).unwrap();
        let declared = construct(SHAPES, &document.root.children[0], &loader, Usage::Unbounded);
        if let Declared::Geometry(geometry) = declared.unwrap_or_else(|e| panic!("{e}")) {
            f(example, &geometry);
        }
    }
    f("fan", &fan());
}

/// Numbers in the unit square, none of them near a line where maps of it fold.
fn numbers() -> impl Iterator<Item = DVec2> {
    const SIDE: u32 = 13;
    let at = |i: u32| (f64::from(i) + 0.37) / f64::from(SIDE);
    (0..SIDE * SIDE).map(move |i| DVec2::new(at(i % SIDE), at(i / SIDE)))
}

/// What a ray straight onto the surface meets next to `p`.
fn seen(shape: &Geometry, accel: &Accel, p: DVec3, n: DVec3) -> Option<(Hit, SurfacePoint)> {
    const HEIGHT: f64 = 1.0 / 16.0;
    let ray = Ray::free(p + n * HEIGHT, -n);
    let hit = accel.closest(&ray).filter(|hit| hit.t < 2.0 * HEIGHT)?;
    Some((hit, shape.point::<true>(&ray, &hit, hit.primitive)))
}

#[test]
fn samples_are_where_rays_meet_the_surface() {
    each(|name, shape| {
        let accel = Accel::new(&[shape]);
        let (cone, ball, (least, greatest)) = (shape.normals(), shape.ball(), shape.bounds());
        for u in numbers() {
            let sample = shape.sample_area::<true>(u);
            let (hit, point) = seen(shape, &accel, sample.p, sample.n).expect("samples are on the surface");
            assert_eq!(hit.primitive, sample.primitive, "{name} {u}");
            assert!(length(point.p - sample.p) <= 4.0 * sample.error, "{name} {u}: {} {}", point.p, sample.p);
            assert!(length(point.ng - sample.n) < 1e-12, "{name} {u}");
            assert!((point.uv - sample.uv).length() < 1e-12, "{name} {u}: {} {}", point.uv, sample.uv);
            assert!(sample.error <= shape.point_error(), "{name} {u}");
            assert!(cone.axis.dot(sample.n) >= cone.cos - 1e-12, "{name} {u}");
            assert!(length(sample.p - ball.centre) <= ball.radius + sample.error, "{name} {u}");
            let bounded =
                sample.p.cmpge(least - sample.error).all() && sample.p.cmple(greatest + sample.error).all();
            assert!(bounded, "{name} {u}");
        }
    });
}

/// A part of the numbers fills as large a part of the surface.
#[test]
fn samples_are_as_dense_as_they_say() {
    const STEP: f64 = 1e-6;
    each(|name, shape| {
        let mut area = 0.0;
        for u in numbers() {
            let at = |by: DVec2| shape.sample_area::<false>(u + by * STEP);
            let across = [DVec2::X, DVec2::Y].map(|by| (at(by).p - at(-by).p) / (2.0 * STEP));
            let stretch = length(across[0].cross(across[1]));
            let pdf = at(DVec2::ZERO).pdf;
            assert!((stretch * pdf - 1.0).abs() < 1e-6, "{name} {u}: {stretch} {pdf}");
            area += stretch;
        }
        let mean = area / numbers().count() as f64;
        assert!((mean / shape.area() - 1.0).abs() < 1e-6, "{name}: {mean} {}", shape.area());
    });
}

#[test]
fn tangents_are_slopes_of_coordinates_and_normals_turn_as_told() {
    const STEP: f64 = 1e-5;
    each(|name, shape| {
        let accel = Accel::new(&[shape]);
        let mut looks = 0;
        for u in numbers() {
            let sample = shape.sample_area::<true>(u);
            let (hit, point) = seen(shape, &accel, sample.p, sample.n).expect("samples are on the surface");
            for (tangent, expected) in [(point.dp_du, DVec2::X), (point.dp_dv, DVec2::Y)] {
                assert!(tangent.dot(point.ng).abs() < 1e-12 * length(tangent), "{name} {u}");
                let at = |by: f64| seen(shape, &accel, point.p + tangent * by, point.ng);
                let (Some((back, before)), Some((front, after))) = (at(-STEP), at(STEP)) else { continue };
                if back.primitive != hit.primitive || front.primitive != hit.primitive {
                    continue;
                }
                let moved = after.uv - before.uv;
                // Coordinates about an axis begin anew after a turn.
                let moved = DVec2::new(moved.x - moved.x.round(), moved.y - moved.y.round()) / (2.0 * STEP);
                assert!((moved - expected).length() < 1e-6, "{name} {u}: {moved} {expected}");
                let turned = (after.ns - before.ns) / (2.0 * STEP);
                let told = shape.normal_change(hit.primitive, &hit, &point, tangent);
                assert!(length(turned - told) < 1e-6 * (1.0 + length(told)), "{name} {u}: {turned} {told}");
                looks += 1;
            }
        }
        assert!(looks > numbers().count(), "{name}: {looks}");
    });
}
