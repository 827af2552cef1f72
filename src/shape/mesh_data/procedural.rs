//! A mesh made by code, for pictures and timings that need fine detail and no file.

use super::MeshData;
use crate::math::function::sincos;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// One kind of relief: equal bumps on points spread evenly over the sphere.
struct Relief {
    /// How many bumps. Fibonacci numbers make their spirals close most evenly.
    count: u32,
    /// How far a bump rises, in radii of the body.
    height: f64,
    /// The chord on the unit sphere, from its tip, at which a bump has come down to nothing.
    reach: f64,
    /// The exponent that sharpens a bump: 3 is a round hill, 9 a thorn.
    sharpness: i32,
}

/// Three scales of detail: spines, the tubercles between them, and a fine grain over both.
const RELIEFS: [Relief; 3] = [
    Relief { count: 89, height: 0.50, reach: 0.21, sharpness: 5 },
    Relief { count: 610, height: 0.055, reach: 0.085, sharpness: 3 },
    Relief { count: 4181, height: 0.010, reach: 0.038, sharpness: 3 },
];

/// How high the body is for its width.
const FLATNESS: f64 = 0.78;

/// A sea urchin: a closed surface with smooth normals and detail at three scales, one unit across at its
/// widest, which stands on the plane y = 0 (y is up). Triangles are counterclockwise seen from outside.
///
/// An icosahedron's 20 triangles are split in four `subdivision` times, at most 10: 7 gives 327 680
/// triangles, the least that shows the finest grain well.
pub fn sea_urchin(subdivision: u32) -> MeshData {
    let (directions, triangles) = icosphere(subdivision.min(10));
    let reliefs = RELIEFS.map(|relief| (spiral(relief.count), relief));
    let surface: Vec<_> = directions.iter().map(|&direction| displaced(direction, &reliefs)).collect();

    let extent = |axis: usize| {
        let along = surface.iter().map(|(point, _)| point[axis]);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let extents = [extent(0), extent(1), extent(2)];
    let width = extents.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
    let ground = extents[1][0];
    let place = |[x, y, z]: [f64; 3]| [x, y - ground, z].map(|coordinate| (coordinate / width) as f32);
    MeshData {
        positions: surface.iter().map(|&(point, _)| place(point)).collect(),
        normals: Some(surface.iter().map(|&(_, normal)| normal.map(|component| component as f32)).collect()),
        triangles,
        ..MeshData::default()
    }
}

/// The point of the surface in direction ω, and its unit normal.
///
/// The surface is r(ω) ω with r = 1 + Σ hᵢ uᵢᵏ over the bumps with tips p, where u = 1 − |ω − p|²/ρ² within
/// the reach ρ. As |ω − p|² = 2 (1 − ω·p), ∇r = Σ h k uᵏ⁻¹ 2p/ρ², and with g its part tangent to the sphere
/// the normal is along r ω − g. Flattening by f along y takes a normal (x, y, z) to (x, y/f, z).
fn displaced(omega: [f64; 3], reliefs: &[(Vec<[f64; 3]>, Relief)]) -> ([f64; 3], [f64; 3]) {
    let mut radius = 1.0;
    let mut gradient = [0.0; 3];
    for (tips, relief) in reliefs {
        let inverse = 2.0 / (relief.reach * relief.reach);
        // Tips come in the order of falling y, which no further than the reach from ω can differ by more.
        let begin = tips.partition_point(|tip| tip[1] > omega[1] + relief.reach);
        let near = tips[begin..].iter().take_while(|tip| tip[1] >= omega[1] - relief.reach);
        for tip in near {
            let u = 1.0 - (1.0 - dot(omega, *tip)) * inverse;
            if u > 0.0 {
                let power = (1..relief.sharpness).fold(1.0, |power, _| power * u);
                radius += relief.height * power * u;
                let slope = relief.height * f64::from(relief.sharpness) * power * inverse;
                gradient = add(gradient, scaled(*tip, slope));
            }
        }
    }
    let tangent = add(gradient, scaled(omega, -dot(gradient, omega)));
    let [x, y, z] = add(scaled(omega, radius), scaled(tangent, -1.0));
    let [px, py, pz] = scaled(omega, radius);
    ([px, FLATNESS * py, pz], normalized([x, y / FLATNESS, z]))
}

/// `count` points spread evenly over the unit sphere from the top down, each the golden angle on from the
/// last (Swinbank and Purser 2006, "Fibonacci grids").
fn spiral(count: u32) -> Vec<[f64; 3]> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let point = |index: u32| {
        let y = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
        let (sine, cosine) = sincos(golden_angle * f64::from(index));
        let radius = (1.0 - y * y).sqrt();
        [radius * cosine, y, radius * sine]
    };
    (0..count).map(point).collect()
}

/// The unit sphere as an icosahedron whose triangles are split in four `subdivision` times.
fn icosphere(subdivision: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (one, phi) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        points.extend([[0.0, one, phi], [one, phi, 0.0], [phi, 0.0, one]].map(normalized));
    }
    let mut triangles = icosahedron(&points);
    for _ in 0..subdivision {
        let mut midpoints = BTreeMap::new();
        let mut midpoint = |a: u32, b: u32| {
            *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push(normalized(add(points[a as usize], points[b as usize])));
                points.len() as u32 - 1
            })
        };
        let split = |[a, b, c]: [u32; 3]| {
            let [ab, bc, ca] = [midpoint(a, b), midpoint(b, c), midpoint(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    (points, triangles)
}

/// The 20 triangles between the 12 corners: every three that are mutual neighbours, wound to face outward.
fn icosahedron(points: &[[f64; 3]]) -> Vec<[u32; 3]> {
    // Neighbours are at a cosine of 1/√5, all others at −1/√5 or −1.
    let near = |a: usize, b: usize| dot(points[a], points[b]) > 0.0;
    let mut triangles = Vec::new();
    for a in 0..points.len() {
        for b in a + 1..points.len() {
            for c in b + 1..points.len() {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = dot(points[a], cross(points[b], points[c])) > 0.0;
                    let [b, c] = if outward { [b, c] } else { [c, b] };
                    triangles.push([a, b, c].map(|corner| corner as u32));
                }
            }
        }
    }
    triangles
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn scaled(a: [f64; 3], factor: f64) -> [f64; 3] {
    a.map(|component| component * factor)
}

fn normalized(a: [f64; 3]) -> [f64; 3] {
    scaled(a, 1.0 / dot(a, a).sqrt())
}

#[cfg(test)]
mod tests {
    use super::{super::tests::assert_valid, *};
    use std::collections::BTreeMap;

    fn corners(mesh: &MeshData, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|vertex| mesh.positions[vertex as usize].map(f64::from))
    }

    #[test]
    fn the_surface_is_closed_and_faces_outward() {
        let mesh = sea_urchin(6);
        assert_valid(&mesh);
        assert_eq!(mesh.triangles.len(), 20 * 4_usize.pow(6));
        // Each edge is walked once each way: two triangles share it, and they agree on which side is out.
        let mut edges = BTreeMap::new();
        for [a, b, c] in &mesh.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|(&(a, b), &count)| count == 1 && edges.contains_key(&(b, a))));
        // Euler: a sphere has V − E + F = 2.
        assert_eq!(mesh.positions.len() + mesh.triangles.len(), edges.len() / 2 + 2);
        let volume: f64 = mesh
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = corners(&mesh, *triangle);
                dot(a, cross(b, c)) / 6.0
            })
            .sum();
        // Between a fifth of the unit cube's inscribed ball and the whole of it.
        assert!(volume > PI / 30.0 && volume < PI / 6.0, "{volume}");
    }

    #[test]
    fn it_stands_on_the_ground_and_is_one_unit_across() {
        let mesh = sea_urchin(4);
        let extent = |axis: usize| {
            let along = || mesh.positions.iter().map(|position| position[axis]);
            (along().fold(f32::INFINITY, f32::min), along().fold(f32::NEG_INFINITY, f32::max))
        };
        let sizes = [0, 1, 2].map(|axis| extent(axis).1 - extent(axis).0);
        assert_eq!(extent(1).0, 0.0);
        // Each end is rounded to f32 once.
        assert!((sizes.into_iter().fold(0.0, f32::max) - 1.0).abs() <= f32::EPSILON);
    }

    #[test]
    fn normals_are_those_of_the_surface() {
        // Central differences across a step h are off by h²/6 times a third derivative: here some 1e-10 ·
        // 1e4.
        let reliefs = RELIEFS.map(|relief| (spiral(relief.count), relief));
        let step = 1e-5;
        for omega in spiral(500) {
            let (_, normal) = displaced(omega, &reliefs);
            let side = normalized(cross(omega, [0.3, 0.5, 0.8]));
            for along in [side, cross(omega, side)] {
                let at = |h: f64| displaced(normalized(add(omega, scaled(along, h))), &reliefs).0;
                let tangent = add(at(step), scaled(at(-step), -1.0));
                let sine = dot(normalized(tangent), normal);
                assert!(sine.abs() < 1e-5, "{sine} at {omega:?}");
            }
        }
    }
}
