//! Procedural meshes of four kinds: round and closed, many of these in a room, long and thin, and a landscape
//! seen from above.

use crate::file::Soup;
use etalon::math::{DVec3, Transform, warp};
use etalon::sampler::{Sampler, SamplerKind};
use etalon::shape::mesh_data::sea_urchin;

/// A mesh with the positions of a camera, its target and a lamp.
pub struct Subject {
    /// The mesh.
    pub soup: Soup,
    /// Position of the camera.
    pub eye: DVec3,
    /// The point that the camera looks at.
    pub target: DVec3,
    /// Centre of the square lamp.
    pub light: DVec3,
}

/// A function that makes a mesh with its positions.
type Making = fn() -> Subject;

/// Every mesh by name; names end with the rounded number of triangles.
pub const MESHES: &[(&str, Making)] = &[
    ("urchin-1k", || urchins(1, 3)),
    ("twigs-60k", twigs),
    ("urchins-164k", || urchins(8, 5)),
    ("landscape-524k", landscape),
    ("urchins-2500k", || urchins(120, 5)),
];

/// Random numbers in [0, 1) that are a function of `index` and `block`.
fn uniform(index: u32, block: u32) -> impl Fn(usize) -> f64 {
    let numbers = Sampler::new(SamplerKind::Independent, 1, (index, 0), 0).block(block);
    move |i| numbers.one(i)
}

impl Soup {
    fn add(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]], place: &Transform) {
        let first = self.positions.len() as u32;
        let place = |p: &[f32; 3]| {
            let p = place.point(DVec3::from(p.map(f64::from)));
            p.to_array().map(|v| v as f32)
        };
        self.positions.extend(positions.iter().map(place));
        self.triangles.extend(triangles.iter().map(|t| t.map(|i| first + i)));
    }

    /// The unit cube about the origin, placed.
    fn add_box(&mut self, place: &Transform) {
        let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 - 0.5);
        let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let halves = sides.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        self.add(&(0..8).map(corner).collect::<Vec<_>>(), halves.as_flattened(), place);
    }
}

fn scale(x: f64, y: f64, z: f64) -> Transform {
    Transform::scale(DVec3::new(x, y, z)).expect("the sizes are constants, none zero")
}

/// A rotation by a random angle about a random axis.
fn turn(u: impl Fn(usize) -> f64) -> Transform {
    let axis = warp::sphere(etalon::math::DVec2::new(u(0), u(1)));
    Transform::rotate(axis, 360.0 * u(2)).expect("the axis has unit length")
}

/// A number of urchins, of 20·4ⁿ triangles each, in a closed room.
fn urchins(count: u32, subdivision: u32) -> Subject {
    let mut soup = Soup::default();
    soup.add_box(&scale(10.0, 5.0, 10.0));
    let urchin = sea_urchin(subdivision);
    let size = if count == 1 { 4.0 } else { 6.0 / libm::cbrt(count as f64) };
    for i in 0..count {
        let (u, v) = (uniform(i, 0), uniform(i, 1));
        let spread = if count == 1 { 0.0 } else { 1.0 };
        let at = DVec3::new(u(0) - 0.5, u(1) - 0.5, u(2) - 0.5) * DVec3::new(8.0, 3.0, 8.0) * spread;
        let place = Transform::translate(at)
            .after(&turn(v))
            .after(&scale(size, size, size))
            .after(&Transform::translate(DVec3::new(0.0, -0.4, 0.0)));
        soup.add(&urchin.positions, &urchin.triangles, &place);
    }
    Subject { soup, eye: DVec3::new(-4.5, 1.5, -4.5), target: DVec3::ZERO, light: DVec3::new(1.0, 2.4, -2.0) }
}

/// Thin sticks across a room in all directions: the bounding boxes of their triangles are nearly empty.
fn twigs() -> Subject {
    let mut soup = Soup::default();
    soup.add_box(&scale(10.0, 5.0, 10.0));
    for i in 0..5000 {
        let (u, v) = (uniform(i, 0), uniform(i, 1));
        let at = DVec3::new(u(0) - 0.5, u(1) - 0.5, u(2) - 0.5) * DVec3::new(8.0, 3.0, 8.0);
        let place = Transform::translate(at).after(&turn(v)).after(&scale(0.01, 0.01, 1.2));
        soup.add_box(&place);
    }
    Subject { soup, eye: DVec3::new(-4.5, 1.5, -4.5), target: DVec3::ZERO, light: DVec3::new(1.0, 2.4, -2.0) }
}

/// A square of hills at five scales under the open sky.
fn landscape() -> Subject {
    const SIDE: u32 = 512;
    let height = |x: f64, z: f64| {
        let octave = |i: u32| {
            let (u, f) = (uniform(i, 0), libm::exp2(i as f64));
            libm::sin(f * (x + 6.0 * u(0))) * libm::sin(f * (z + 6.0 * u(1)) + u(2) * x) / (1.2 * f)
        };
        (0..7).map(octave).sum::<f64>()
    };
    let mut soup = Soup::default();
    for row in 0..=SIDE {
        for column in 0..=SIDE {
            let [x, z] = [column, row].map(|i| 10.0 * (i as f64 / SIDE as f64 - 0.5));
            soup.positions.push([x, height(x, z), z].map(|v| v as f32));
            if row < SIDE && column < SIDE {
                let a = row * (SIDE + 1) + column;
                let below = a + SIDE + 1;
                soup.triangles.extend([[a, below, a + 1], [a + 1, below, below + 1]]);
            }
        }
    }
    Subject {
        soup,
        eye: DVec3::new(-5.5, 3.0, -5.5),
        target: DVec3::new(0.0, -0.5, 0.0),
        light: DVec3::new(6.0, 5.0, 1.0),
    }
}
