//! A cube, or what an affine map makes of one.

use super::patch::{Outline, Patch};
use super::{AreaSample, Geometry, SurfacePoint, placement};
use crate::math::ray::position_error;
use crate::math::{Bounds, Chosen, DVec2, DVec3, Discrete, Transform, length};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use glam::DMat4;

pub const NAME: &str = "cube";
pub const ABOUT: &str = "The cube from (−1, −1, −1) to (1, 1, 1); uv cover each face once.";
pub const EXAMPLES: &[&str] = &[
    r#"<shape type="cube"/>"#,
    r#"<shape type="cube"><transform name="to_world"><scale x="2" y="0.1" z="1"/></transform></shape>"#,
];

/// The outward normal of each face and its directions of u and v, in Mitsuba's order.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::NEG_Y, DVec3::Z, DVec3::X],
    [DVec3::Y, DVec3::NEG_X, DVec3::NEG_Z],
    [DVec3::X, DVec3::Y, DVec3::NEG_Z],
    [DVec3::Z, DVec3::Y, DVec3::X],
    [DVec3::NEG_X, DVec3::Y, DVec3::Z],
    [DVec3::NEG_Z, DVec3::NEG_Y, DVec3::X],
];

/// Which of the faces lie across each axis: the one at −1 and the one at 1.
pub const ACROSS: [[u32; 2]; 3] = [[4, 2], [0, 1], [5, 3]];

/// A parallelepiped in world space. Each face is a primitive of its own, but rays try all six together.
#[derive(Clone, Debug)]
pub struct Cube {
    pub centre: DVec3,
    /// From the centre to the middles of the faces at 1.
    axes: [DVec3; 3],
    /// Products with p − centre are the coordinates in the cube: the dual basis of the axes.
    pub dual: [DVec3; 3],
    faces: Box<[Patch; 6]>,
    areas: Discrete,
    /// See [`Geometry::point_error`].
    error: f64,
}

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let (to_world, flip) = placement(params)?;
    params.boolean("face_normals", false, "Mitsuba's; ignored, for its faces are flat")?;
    Ok(Geometry::Cube(Cube::new(&to_world, flip)))
}

impl Cube {
    pub const FACES: u32 = FACES.len() as u32;

    pub fn new(to_world: &Transform, flip: bool) -> Self {
        let faces = FACES.map(|[n, u, v]| {
            let matrix = DMat4::from_cols(u.extend(0.0), v.extend(0.0), n.extend(0.0), n.extend(1.0));
            // A rotation or reflection, and a translation along an axis: the inverse has no rounding.
            let side = Transform { matrix, inverse: matrix.inverse() };
            Patch::new(&to_world.after(&side), flip, Outline::Square)
        });
        let (centre, axes) = (to_world.point(DVec3::ZERO), DVec3::AXES.map(|axis| to_world.vector(axis)));
        Self {
            centre,
            axes,
            error: error_of_points(centre, axes),
            dual: dual_basis(axes),
            areas: Discrete::new(faces.iter().map(Patch::area)),
            faces: Box::new(faces),
        }
    }

    /// Moves every face to its front by this distance (world), inward by half of the way to the centre at most.
    pub fn raise(&mut self, by: f64) {
        let face = &self.faces[0];
        let inward = face.n.dot(face.centre - self.centre) < 0.0;
        // A dual vector is as long as the way from the centre to a face is short.
        let nearest = self.dual.into_iter().map(|dual| 1.0 / length(dual)).fold(f64::INFINITY, f64::min);
        let by = if inward { -by.min(0.5 * nearest) } else { by };
        let longer = |axis: DVec3, dual: DVec3| axis * (1.0 + by * length(dual));
        self.axes = std::array::from_fn(|i| longer(self.axes[i], self.dual[i]));
        self.dual = dual_basis(self.axes);
        let along = |way: DVec3| self.axes[0] * way.x + self.axes[1] * way.y + self.axes[2] * way.z;
        for (face, [n, u, v]) in self.faces.iter_mut().zip(FACES) {
            *face = face.moved(self.centre + along(n), along(u), along(v));
        }
        self.areas = Discrete::new(self.faces.iter().map(Patch::area));
        self.error = error_of_points(self.centre, self.axes);
    }

    pub fn faces(&self) -> &[Patch; 6] {
        &self.faces
    }

    /// The point of a face nearest to `near`.
    #[inline(always)]
    pub fn point<const UV: bool>(&self, face: u32, near: DVec3) -> SurfacePoint {
        let patch = &self.faces[face as usize];
        let from_centre = near - patch.centre;
        let in_plane = from_centre - patch.n * patch.n.dot(from_centre);
        let p = patch.centre + in_plane;
        if !UV {
            return SurfacePoint::plain(p, patch.n, patch.n, self.error);
        }
        let in_cube = DVec3::from_array(self.dual.map(|dual| dual.dot(p - self.centre)));
        // Rounding leads beyond an edge, but not beyond the texture.
        let [x, y] = [1, 2].map(|side| FACES[face as usize][side].dot(in_cube).clamp(-1.0, 1.0));
        SurfacePoint { p, error: self.error, ..patch.point::<true>(x, y) }
    }

    /// The area in m² of the surface (world).
    pub fn area(&self) -> f64 {
        self.areas.total()
    }

    /// See [`Geometry::point_error`].
    pub fn point_error(&self) -> f64 {
        self.error
    }

    /// A point of the surface from two numbers in [0, 1), with its density in m⁻²; texture coordinates if `UV`.
    pub fn sample_area<const UV: bool>(&self, u: DVec2) -> AreaSample {
        let Chosen { index: face, rest: x, .. } = self.areas.sample(u.x);
        let sample = self.faces[face].sample_area::<UV>(DVec2::new(x, u.y));
        AreaSample { pdf: 1.0 / self.area(), primitive: face as u32, error: self.error, ..sample }
    }

    pub fn corners(&self) -> Vec<DVec3> {
        [3, 5].iter().flat_map(|&face| self.faces[face].corners()).collect()
    }

    /// The least and the greatest coordinates (world).
    pub fn bounds(&self) -> Bounds {
        let [a, b, c] = self.axes.map(DVec3::abs);
        (self.centre - a - b - c, self.centre + a + b + c)
    }
}

/// The vectors of which each has the product 1 with one of three, and 0 with the others.
pub fn dual_basis([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    let volume = a.dot(b.cross(c));
    [b.cross(c) / volume, c.cross(a) / volume, a.cross(b) / volume]
}

fn error_of_points(centre: DVec3, axes: [DVec3; 3]) -> f64 {
    let [a, b, c] = axes.map(DVec3::abs);
    position_error(centre.abs() + a + b + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::{length, unit};
    use crate::math::random::{direction, uniform};
    use crate::math::{Ray, Transform};
    use crate::shape::accel::Accel;
    use crate::shape::mesh_data::MeshData;
    use crate::shape::{Hit, Mesh, Normals};
    use rand_pcg::Pcg32;

    /// Mitsuba's cube: each face's normal, and the corners in the order of uv (0,1), (1,1), (1,0), (0,0). Bit
    /// k of a corner is the sign of axis k.
    const OF_TRIANGLES: [([f32; 3], [u8; 4]); 6] = [
        ([0.0, -1.0, 0.0], [1, 5, 4, 0]),
        ([0.0, 1.0, 0.0], [3, 2, 6, 7]),
        ([1.0, 0.0, 0.0], [1, 3, 7, 5]),
        ([0.0, 0.0, 1.0], [5, 7, 6, 4]),
        ([-1.0, 0.0, 0.0], [4, 6, 2, 0]),
        ([0.0, 0.0, -1.0], [3, 1, 0, 2]),
    ];

    fn as_mesh(to_world: &Transform, flip: bool) -> Geometry {
        let (mut positions, mut normals, mut uvs, mut triangles) = (vec![], vec![], vec![], vec![]);
        for (normal, corners) in OF_TRIANGLES {
            let first = positions.len() as u32;
            for (corner, uv) in corners.into_iter().zip([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]) {
                positions.push([0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 }));
                normals.push(normal);
                uvs.push(uv);
            }
            triangles.extend([[first, first + 1, first + 2], [first + 3, first, first + 2]]);
        }
        let data =
            MeshData { positions, normals: Some(normals), uvs: Some(uvs), triangles, attributes: None };
        Geometry::Mesh(Mesh::new(data, to_world, Normals { flipped: flip, ..Normals::default() }))
    }

    /// A place with a shear, with or without a reflection.
    fn place(rng: &mut Pcg32, mirror: bool) -> Transform {
        let scale = DVec3::new(0.2 + uniform(rng), 0.2 + uniform(rng), if mirror { -0.7 } else { 0.7 });
        let turn = |rng: &mut Pcg32| Transform::rotate(direction(rng), 360.0 * uniform(rng)).unwrap();
        let scale = turn(rng).after(&Transform::scale(scale).unwrap()).after(&turn(rng));
        Transform::translate(direction(rng) * 2.0).after(&scale)
    }

    #[test]
    fn it_looks_like_its_triangles() {
        let mut rng = Pcg32::new(0, 0);
        for i in 0..40 {
            let (mirror, flip) = (i % 2 == 1, i % 4 > 1);
            let to_world = place(&mut rng, mirror);
            let (cube, mesh) = (Geometry::Cube(Cube::new(&to_world, flip)), as_mesh(&to_world, flip));
            assert!((cube.area() / mesh.area() - 1.0).abs() < 1e-6);
            let [ours, theirs] = [&cube, &mesh].map(|shape| Accel::new(&[shape]));
            let mut met = 0;
            for _ in 0..500 {
                let towards = to_world.point(direction(&mut rng) * 1.5 * uniform(&mut rng));
                // From within too.
                let origin = to_world.point(direction(&mut rng) * 4.0 * uniform(&mut rng));
                let ray = Ray::free(origin, unit(towards - origin));
                let [Some(hit), Some(expected)] = [&ours, &theirs].map(|accel| accel.closest(&ray)) else {
                    continue;
                };
                let see = |shape: &Geometry, hit: &Hit| shape.point::<true>(&ray, hit, hit.primitive);
                let (point, other) = (see(&cube, &hit), see(&mesh, &expected));
                // Near an edge the two may meet different faces, and along a face they meet it far apart.
                if hit.primitive != expected.primitive / 2 || ray.direction.dot(point.ng).abs() < 0.01 {
                    continue;
                }
                met += 1;
                assert!((hit.t - expected.t).abs() < 1e-4, "{hit:?} {expected:?}");
                let pairs = [(point.p, other.p), (point.dp_du, other.dp_du), (point.dp_dv, other.dp_dv)];
                assert!(pairs.iter().all(|(a, b)| length(*a - *b) < 1e-4), "{point:?} {other:?}");
                assert!(length(point.ng - other.ng) < 1e-5 && length(point.ns - other.ns) < 1e-5);
                assert!((point.uv - other.uv).length() < 1e-4, "{point:?} {other:?}");
                let index = cube.mitsuba_primitive(hit.primitive, &point);
                let diagonal = point.uv.x + point.uv.y - 1.0;
                assert!(diagonal.abs() < 1e-3 || index == expected.primitive, "{index} {expected:?}");
                let plain = cube.point::<false>(&ray, &hit, hit.primitive);
                assert_eq!((plain.p, plain.ng, plain.ns), (point.p, point.ng, point.ns));
            }
            assert!(met > 100, "{met}");
        }
    }

    #[test]
    fn raised_inward_a_cube_is_not_turned_inside_out() {
        let plate = Transform::scale(DVec3::new(1.0, 1.0, 1e-3)).unwrap();
        for (by, half) in [(1e-4, 9e-4), (1e-2, 5e-4)] {
            let mut cube = Cube::new(&plate, true);
            cube.raise(by);
            let (lo, hi) = cube.bounds();
            assert!((hi.z - half).abs() < 1e-12 && (lo.z + half).abs() < 1e-12, "{by}: {lo} {hi}");
        }
        let mut cube = Cube::new(&plate, false);
        cube.raise(1e-2);
        assert!((cube.bounds().1.z - 1.1e-2).abs() < 1e-12);
    }

    #[test]
    fn rays_from_a_face_leave_it_or_cross_the_cube() {
        let mut rng = Pcg32::new(0, 1);
        for i in 0..20 {
            let to_world = place(&mut rng, i % 2 == 1);
            let cube = Cube::new(&to_world, false);
            let shape = Geometry::Cube(cube.clone());
            let accel = Accel::new(&[&shape]);
            for j in 0..5000 {
                // Every other one next to an edge, and every other one along it or along the face.
                let near_edge = |x: f64| if j % 2 == 0 { x } else { 1.0 - x * f64::EPSILON };
                let face = (uniform(&mut rng) * 6.0) as u32;
                let patch = &cube.faces()[face as usize];
                let p = patch.centre + patch.e1 * near_edge(uniform(&mut rng)) + patch.e2 * uniform(&mut rng);
                let flat = if j % 4 > 1 { 1e-12 * uniform(&mut rng) } else { 1.0 };
                let d = direction(&mut rng);
                let d = unit(d - patch.n * (d.dot(patch.n) * (1.0 - flat)));
                let hit = accel.closest(&Ray::leaving(p, d, f64::INFINITY, face));
                let slope = d.dot(patch.n);
                if slope.abs() < 1e-14 {
                    continue;
                }
                let outward = slope > 0.0;
                assert!(!(outward && hit.is_some()), "{face} {p} {d} {hit:?}");
                if !outward && j % 4 == 0 {
                    assert!(hit.is_some_and(|hit| hit.primitive != face), "{face} {p} {d} {hit:?}");
                }
            }
        }
    }

    #[test]
    fn points_are_chosen_by_area() {
        let cube = Cube::new(&Transform::scale(DVec3::new(1.0, 2.0, 3.0)).unwrap(), false);
        let mut chosen = [0.0_f64; 6];
        for i in 0..8800 {
            let sample = cube.sample_area::<false>(DVec2::new((f64::from(i) + 0.5) / 8800.0, 0.3));
            chosen[sample.primitive as usize] += 88.0 / 8800.0;
            assert_eq!(sample.pdf, 1.0 / 88.0);
            let [x, y, z] = (sample.p.abs() / DVec3::new(1.0, 2.0, 3.0)).to_array();
            assert!((x.max(y).max(z) - 1.0).abs() < 1e-12, "{sample:?}");
        }
        for (chosen, area) in chosen.iter().zip([12.0, 12.0, 24.0, 8.0, 24.0, 8.0]) {
            assert!((chosen - area).abs() < 0.02, "{chosen} of {area}");
        }
    }
}
