//! Triangle meshes in world space.

use super::mesh_data::{AttributeFile, MeshData};
use super::{AreaSample, Chart, SurfacePoint};
use crate::math::bounds::around;
use crate::math::frame::{length, unit};
use crate::math::function::acos;
use crate::math::ray::position_error;
use crate::math::simd::prefetch;
use crate::math::{Ball, Bounds, Chosen, DVec2, DVec3, Discrete, Frame, Transform, warp};
use std::sync::Arc;

/// Vertices are rounded to `f32` once, after the transform; all that is computed from them is `f64`.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals; `None` means the triangles are flat.
    normals: Option<Vec<[f32; 3]>>,
    uvs: Option<Vec<[f32; 2]>>,
    /// What texture coordinates belong to, where textures are attributes.
    chart: Option<Arc<Chart>>,
    /// From the file's coordinates. In a box of its own, for nothing that is traced needs it.
    placement: Box<Transform>,
    /// Where its attributes are.
    attributes: Option<AttributeFile>,
    /// Whether the winding of triangles gives the back side.
    flipped: bool,
    /// Distribution of triangles by area, for meshes that emit.
    areas: Discrete,
    /// Rounding error of a mesh that emits; see [`Geometry::point_error`](super::Geometry::point_error).
    error: f64,
    bounds: Bounds,
}

fn double(v: [f32; 3]) -> DVec3 {
    DVec3::new(v[0] as f64, v[1] as f64, v[2] as f64)
}

fn single(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// A vertex attribute at barycentric coordinates.
#[inline(always)]
fn interpolated([n0, n1, n2]: [DVec3; 3], u: f64, v: f64) -> DVec3 {
    n0 + (n1 - n0) * u + (n2 - n0) * v
}

/// Which normals a mesh has.
#[derive(Clone, Copy, Debug, Default)]
pub struct Normals {
    /// Those of its triangles, whatever normals the file has.
    pub of_faces: bool,
    /// The surface is turned inside out.
    pub flipped: bool,
}

impl Normals {
    /// Those of the triangles, as they are wound.
    pub const OF_FACES: Self = Self { of_faces: true, flipped: false };
}

impl Mesh {
    /// Places a mesh. Where the file has no normals they are made from the geometry, unless they are those of faces.
    ///
    /// As in Mitsuba, stored normals keep their side under a mirroring transform. The surface itself is turned to
    /// theirs, whatever its winding: so the front, where a one-sided material reflects, is where a lamp shines.
    pub fn new(data: MeshData, to_world: &Transform, Normals { of_faces, flipped: flip }: Normals) -> Self {
        let positions: Vec<[f32; 3]> =
            data.positions.iter().map(|&p| single(to_world.point(double(p)))).collect();
        let side = if flip { -1.0 } else { 1.0 };
        let stored = data.normals.filter(|_| !of_faces);
        let (triangles, uvs) = (data.triangles, data.uvs);
        let (normals, flipped) = match stored {
            _ if of_faces => (None, flip),
            Some(normals) => {
                let place = |n: &[f32; 3]| single(to_world.normal(double(*n)).normalize_or_zero() * side);
                let normals: Vec<[f32; 3]> = normals.iter().map(place).collect();
                let agreement = agreement(&positions, &triangles, &normals);
                (Some(normals), if agreement == 0.0 { flip } else { agreement < 0.0 })
            }
            None => (Some(smooth_normals(&positions, &triangles, side)), flip),
        };
        let bounds = around(positions.iter().map(|&p| double(p)));
        let error = position_error(bounds.0.abs().max(bounds.1.abs()));
        Self {
            positions,
            triangles,
            normals,
            uvs,
            chart: None,
            placement: Box::new(*to_world),
            attributes: data.attributes,
            flipped,
            areas: Discrete::default(),
            error,
            bounds,
        }
    }

    /// The transform from the file's coordinates, which were rounded to `f32` as well.
    pub fn placement(&self) -> &Transform {
        &self.placement
    }

    /// The vertices of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|i| double(self.positions[i as usize]))
    }

    /// Prefetches the numbers of a triangle's corners.
    pub fn prefetch_triangle(&self, triangle: u32) {
        prefetch(&self.triangles, triangle as usize);
    }

    /// Prefetches the corners of a triangle.
    pub fn prefetch_corners(&self, triangle: u32) {
        for corner in self.triangles[triangle as usize] {
            prefetch(&self.positions, corner as usize);
            self.normals.iter().for_each(|normals| prefetch(normals, corner as usize));
        }
    }

    /// The point p₀ + u(p₁ − p₀) + v(p₂ − p₀) of a triangle.
    #[inline(always)]
    pub fn point<const UV: bool>(&self, triangle: u32, u: f64, v: f64) -> SurfacePoint {
        let [p0, p1, p2] = self.corners(triangle);
        let (e1, e2) = (p1 - p0, p2 - p0);
        let ng = unit(e1.cross(e2));
        let ng = if self.flipped { -ng } else { ng };
        let indices = self.triangles[triangle as usize];
        let ns = match &self.normals {
            None => ng,
            Some(normals) => {
                let n = interpolated(indices.map(|i| double(normals[i as usize])), u, v);
                // Opposite normals may cancel, and files may hold zeros: there the surface itself decides.
                if n.length_squared() > 0.0 { unit(n) } else { ng }
            }
        };
        let (uv, dp_du, dp_dv) = match &self.uvs {
            _ if !UV => (DVec2::ZERO, DVec3::ZERO, DVec3::ZERO),
            None => (DVec2::new(u, v), e1, e2),
            Some(uvs) => {
                let [t0, t1, t2] =
                    indices.map(|i| DVec2::new(uvs[i as usize][0] as f64, uvs[i as usize][1] as f64));
                let (d1, d2) = (t1 - t0, t2 - t0);
                let determinant = d1.x * d2.y - d1.y * d2.x;
                let (dp_du, dp_dv) = if determinant != 0.0 {
                    ((e1 * d2.y - e2 * d1.y) / determinant, (e2 * d1.x - e1 * d2.x) / determinant)
                } else {
                    // Any two directions along the surface: Mitsuba takes the same.
                    let frame = Frame::about(ng);
                    (frame.s, frame.t)
                };
                (t0 + d1 * u + d2 * v, dp_du, dp_dv)
            }
        };
        let uv = if UV && self.chart.is_some() { Chart::coordinates(triangle, u, v) } else { uv };
        let p = p0 + e1 * u + e2 * v;
        SurfacePoint { p, ng, ns, uv, dp_du, dp_dv, error: position_error(p) }
    }

    /// Lets points have the coordinates of a chart from now on, for textures that are attributes; `None` if the
    /// mesh's file holds no attributes.
    pub fn draw_chart(&mut self) -> Option<Arc<Chart>> {
        let attributes = self.attributes.clone()?;
        let areas = (0..self.triangles.len() as u32).map(|i| self.triangle_area(i)).collect();
        let chart = Chart::new(self.triangles.clone(), self.uvs.clone(), areas, attributes);
        self.chart = Some(Arc::new(chart));
        self.chart.clone()
    }

    /// The texture coordinates that the file gives to a point.
    pub fn file_uv(&self, point: &SurfacePoint) -> DVec2 {
        self.chart.as_ref().map_or(point.uv, |chart| chart.uv(point.uv))
    }

    /// See [`Geometry::normal_change`](super::Geometry::normal_change).
    pub fn normal_change(&self, triangle: u32, (u, v): (f64, f64), dp: DVec3) -> DVec3 {
        let Some(normals) = &self.normals else { return DVec3::ZERO };
        let [p0, p1, p2] = self.corners(triangle);
        let [n0, n1, n2] = self.triangles[triangle as usize].map(|i| double(normals[i as usize]));
        let n = interpolated([n0, n1, n2], u, v);
        let (e1, e2) = (p1 - p0, p2 - p0);
        // dp = e₁ du + e₂ dv, by the vectors dual to the edges.
        let across = e1.cross(e2);
        let size = across.length_squared();
        let (du, dv) = (dp.dot(e2.cross(across)) / size, dp.dot(across.cross(e1)) / size);
        let change = (n1 - n0) * du + (n2 - n0) * dv;
        let size = n.length_squared();
        if size > 0.0 { (change - n * (n.dot(change) / size)) / size.sqrt() } else { DVec3::ZERO }
    }

    fn triangle_area(&self, triangle: u32) -> f64 {
        let [p0, p1, p2] = self.corners(triangle);
        0.5 * length((p1 - p0).cross(p2 - p0))
    }

    /// The area in m² of the surface (world).
    pub fn area(&self) -> f64 {
        if self.areas.is_empty() {
            (0..self.triangles.len() as u32).map(|i| self.triangle_area(i)).sum()
        } else {
            self.areas.total()
        }
    }

    /// Builds the table that [`Mesh::sample_area`] needs; only meshes that emit have it.
    pub fn prepare_sampling(&mut self) {
        self.areas = Discrete::new((0..self.triangles.len() as u32).map(|i| self.triangle_area(i)));
    }

    /// See [`Geometry::point_error`](super::Geometry::point_error).
    pub fn point_error(&self) -> f64 {
        self.error
    }

    /// A point of the surface from two numbers in [0, 1), with its density in m⁻²; texture coordinates if `UV`.
    #[inline]
    pub fn sample_area<const UV: bool>(&self, u: DVec2) -> AreaSample {
        let Chosen { index: triangle, rest, .. } = self.areas.sample(u.x);
        let b = warp::triangle(DVec2::new(rest, u.y));
        let point = self.point::<UV>(triangle as u32, b.x, b.y);
        AreaSample {
            p: point.p,
            n: point.ng,
            uv: point.uv,
            pdf: 1.0 / self.areas.total(),
            primitive: triangle as u32,
            error: self.error,
        }
    }

    /// Bytes of the vertex and index arrays.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.positions)
            + size_of_val(&*self.triangles)
            + self.normals.as_deref().map_or(0, size_of_val)
            + self.uvs.as_deref().map_or(0, size_of_val)
            + self.chart.as_ref().map_or(0, |chart| chart.bytes())
    }

    /// The least and the greatest coordinates (world).
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// A ball around it.
    pub fn ball(&self) -> Ball {
        Ball::of_points(self.positions.iter().map(|&p| double(p)))
    }
}

/// Vertex normals weighted by the angle of each triangle at the vertex (Thürmer & Wüthrich 1998). As in
/// Mitsuba, a point that a file splits into vertices for its texture coordinates has a crease there.
fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]], side: f64) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let p = triangle.map(|i| double(positions[i as usize]));
        let n = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
        for i in 0..3 {
            let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            let cos = a.dot(b) / (length(a) * length(b));
            if n != DVec3::ZERO && cos.is_finite() {
                sums[triangle[i] as usize] += n * acos(cos.clamp(-1.0, 1.0));
            }
        }
    }
    sums.into_iter().map(|sum| single(sum.normalize_or_zero() * side)).collect()
}

/// The integral of the cosine between normals and the surface as it is wound, up to a factor: negative if most
/// of it is wound against its normals.
fn agreement(positions: &[[f32; 3]], triangles: &[[u32; 3]], normals: &[[f32; 3]]) -> f64 {
    let of_triangle = |triangle: &[u32; 3]| {
        let [p0, p1, p2] = triangle.map(|i| double(positions[i as usize]));
        let [n0, n1, n2] = triangle.map(|i| double(normals[i as usize]));
        (p1 - p0).cross(p2 - p0).dot(n0 + n1 + n2)
    };
    triangles.iter().map(of_triangle).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(normals: bool) -> MeshData {
        MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: normals.then(|| vec![[0.0, 0.0, 1.0]; 3]),
            uvs: Some(vec![[0.0, 0.0], [2.0, 0.0], [0.0, 4.0]]),
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        }
    }

    #[test]
    fn mirroring_turns_geometry_but_not_stored_normals() {
        let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).unwrap();
        for (normals, face, flip, expected) in [
            (true, false, false, 1.0),
            (true, false, true, -1.0),
            (false, false, false, -1.0),
            (false, true, true, 1.0),
        ] {
            let point = Mesh::new(triangle(normals), &mirror, Normals { of_faces: face, flipped: flip })
                .point::<true>(0, 0.2, 0.2);
            assert_eq!((point.ns.z, point.ng.z), (expected, expected), "{normals} {face} {flip}");
        }
    }

    /// As lamps of some programs are written.
    #[test]
    fn a_mesh_that_is_wound_against_its_normals_is_turned_to_them() {
        for flip in [false, true] {
            let data = MeshData { triangles: vec![[0, 2, 1]], ..triangle(true) };
            let mesh = Mesh::new(data, &Transform::IDENTITY, Normals { flipped: flip, ..Normals::default() });
            let (point, expected) = (mesh.point::<true>(0, 0.2, 0.2), if flip { -1.0 } else { 1.0 });
            assert_eq!((point.ns.z, point.ng.z), (expected, expected), "{flip}");
        }
        // Without normals to go by, as it is wound.
        let zeros = MeshData { normals: Some(vec![[0.0; 3]; 3]), ..triangle(true) };
        let flipped = Normals { flipped: true, ..Normals::default() };
        let point = Mesh::new(zeros, &Transform::IDENTITY, flipped).point::<true>(0, 0.2, 0.2);
        assert_eq!(point.ng.z, -1.0);
    }

    #[test]
    fn points_interpolate_and_tangents_follow_the_texture() {
        let point =
            Mesh::new(triangle(true), &Transform::IDENTITY, Normals::default()).point::<true>(0, 0.25, 0.5);
        assert_eq!((point.p, point.uv), (DVec3::new(0.25, 0.5, 0.0), DVec2::new(0.5, 2.0)));
        assert_eq!(point.dp_du, DVec3::new(0.5, 0.0, 0.0));
        assert_eq!(point.dp_dv, DVec3::new(0.0, 0.25, 0.0));
    }

    /// Unit normals at the corners of a triangle.
    const NORMALS: [[f32; 3]; 3] = [[0.0, 0.6, 0.8], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]];

    fn curved() -> Mesh {
        let data = MeshData { normals: Some(NORMALS.to_vec()), ..triangle(true) };
        Mesh::new(data, &Transform::IDENTITY, Normals::default())
    }

    #[test]
    fn normals_are_those_of_the_nearest_corner() {
        let mesh = curved();
        for (corner, (u, v)) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].into_iter().enumerate() {
            let expected = double(NORMALS[corner]);
            // Unit in f32, and made unit again in f64.
            assert!(length(mesh.point::<true>(0, u, v).ns - expected) < 1e-6, "{corner}");
        }
    }

    /// A corner of a cube, one of whose sides is cut in two: by angles the diagonal counts for nothing.
    #[test]
    fn smooth_normals_do_not_depend_on_how_a_face_is_cut() {
        let corner = MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 4], [0, 4, 2], [0, 2, 3], [0, 3, 1]],
            ..MeshData::default()
        };
        let n = Mesh::new(corner, &Transform::IDENTITY, Normals::default()).point::<true>(0, 0.0, 0.0).ns;
        assert!(length(n - DVec3::splat(1.0 / 3f64.sqrt())) < 1e-6, "{n}");
    }

    #[test]
    fn normals_change_as_their_differences_do() {
        let mesh = curved();
        const STEP: f64 = 1e-5;
        for dp in [DVec3::X, DVec3::Y, DVec3::new(0.3, -0.8, 0.0)] {
            let at = |t: f64| mesh.point::<true>(0, 0.3 + t * dp.x, 0.4 + t * dp.y).ns;
            let expected = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            assert!(length(mesh.normal_change(0, (0.3, 0.4), dp) - expected) < 1e-9, "{dp}");
        }
    }

    #[test]
    fn area_samples_fill_the_triangles() {
        let mut mesh = Mesh::new(triangle(true), &Transform::IDENTITY, Normals::default());
        mesh.prepare_sampling();
        let sample = mesh.sample_area::<true>(DVec2::new(0.3, 0.7));
        assert!(sample.p.x >= 0.0 && sample.p.y >= 0.0 && sample.p.x + sample.p.y <= 1.0);
        assert_eq!(sample.pdf, 2.0);
    }
}
