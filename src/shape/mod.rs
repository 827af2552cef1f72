//! Shapes, one file each, and `accel/`, which finds the first primitive that a ray hits.
//!
//! *How to add one*: write `shape/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and a `parse` that makes a
//! [`Geometry`], and add its line to `shapes!`. A shape that is not made of triangles also needs a variant of
//! [`Geometry`].

pub mod accel;
mod chart;
#[cfg(test)]
mod contract;
pub mod cube;
pub mod cylinder;
mod disk;
mod instance;
pub mod mesh;
pub mod mesh_data;
mod mesh_file;
mod obj;
mod patch;
mod ply;
mod rectangle;
mod serialized;
mod shapegroup;
mod sphere;

use crate::math::bounds::corners;
use crate::math::cone::Cone;
use crate::math::ray::Ends;
use crate::math::{Ball, Bounds, DVec2, DVec3, Frame, Ray, Transform, length};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::registry::Entry;
pub use chart::Chart;
pub use cube::Cube;
pub use cylinder::Cylinder;
pub use mesh::{Mesh, Normals};
pub use patch::{Outline, Patch};
pub use sphere::{Sphere, SphereSample};

/// What a `<shape>` in a scene file may declare.
#[derive(Debug)]
pub enum Declared {
    /// A surface.
    Geometry(Geometry),
    /// Surfaces, nested in the element, that are seen only through instances.
    Group,
    /// An instance of the group nested in the element, placed in the world.
    Instance(Transform),
}

macro_rules! shapes {
    ($($module:ident => $declared:expr),* $(,)?) => {
        /// Every shape.
        pub static SHAPES: &[Entry<Declared>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: |params| $module::parse(params).map($declared),
        }),*];
    };
}
shapes! {
    rectangle => Declared::Geometry,
    sphere => Declared::Geometry,
    disk => Declared::Geometry,
    cube => Declared::Geometry,
    cylinder => Declared::Geometry,
    obj => Declared::Geometry,
    ply => Declared::Geometry,
    serialized => Declared::Geometry,
    shapegroup => |()| Declared::Group,
    instance => Declared::Instance,
}

/// The surface of a shape in world space.
#[derive(Clone, Debug)]
pub enum Geometry {
    Mesh(Mesh),
    Patch(Patch),
    Cube(Cube),
    Sphere(Sphere),
    Cylinder(Cylinder),
}

/// Where a ray met a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray.
    pub t: f64,
    /// First barycentric or patch coordinate; 0 on cubes and quadrics.
    pub u: f64,
    /// Second barycentric or patch coordinate; 0 on cubes and quadrics.
    pub v: f64,
    /// The primitive, counted over the whole scene.
    pub primitive: u32,
}

/// A point on a surface, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    pub p: DVec3,
    /// Unit normal of the surface itself, on the side of the shading normal.
    pub ng: DVec3,
    /// Unit shading normal.
    pub ns: DVec3,
    pub uv: DVec2,
    /// ∂p/∂u, the preferred direction of anisotropic materials.
    pub dp_du: DVec3,
    /// ∂p/∂v.
    pub dp_dv: DVec3,
    /// A bound of the rounding error of `p`: [`Geometry::point_error`], but that of a mesh's points is that of their
    /// coordinates alone, for triangles next to a ray's start know by how much they may be wrong.
    pub error: f64,
}

impl SurfacePoint {
    /// A point whose texture coordinates are not needed.
    pub fn plain(p: DVec3, ng: DVec3, ns: DVec3, error: f64) -> Self {
        Self { p, ng, ns, uv: DVec2::ZERO, dp_du: DVec3::ZERO, dp_dv: DVec3::ZERO, error }
    }

    /// A point in the plane z = 0 with its normal along +z, to evaluate a material by itself.
    pub fn flat() -> Self {
        let n = DVec3::Z;
        let uv = DVec2::new(0.5, 0.5);
        Self { p: DVec3::ZERO, ng: n, ns: n, uv, dp_du: DVec3::X, dp_dv: DVec3::Y, error: 0.0 }
    }

    /// A ray that leaves the point, which lies on this primitive, to distance `end`.
    ///
    /// The line of a point that is beside its surface by `error` crosses that surface within error/cos, and so it does
    /// another surface in the same place, which must not be met: two of them look like one.
    #[inline]
    pub fn ray(&self, direction: DVec3, end: f64, primitive: u32) -> Ray {
        let cos = self.ng.dot(direction).abs().max(f64::MIN_POSITIVE);
        Ray { origin: self.p, direction, start: self.error / cos, end, from: primitive, ends: Ends::Anywhere }
    }

    /// The local frame in which materials work.
    #[inline]
    pub fn frame(&self, anisotropic: bool) -> Frame {
        if anisotropic { Frame::along(self.ns, self.dp_du) } else { Frame::about(self.ns) }
    }
}

/// A sampled point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    pub p: DVec3,
    /// Unit normal on the emitting side.
    pub n: DVec3,
    pub uv: DVec2,
    /// Density with respect to area.
    pub pdf: f64,
    /// The primitive it lies on, counted over this shape.
    pub primitive: u32,
    /// See [`Geometry::point_error`].
    pub error: f64,
}

impl Geometry {
    /// How many primitives rays can meet.
    pub fn primitives(&self) -> u32 {
        match self {
            Self::Mesh(mesh) => mesh.triangles.len() as u32,
            Self::Cube(_) => Cube::FACES,
            _ => 1,
        }
    }

    /// The number that Mitsuba gives to primitive `local` at a point of it: Mitsuba's cubes and rectangles
    /// are made of triangles.
    pub fn mitsuba_primitive(&self, local: u32, point: &SurfacePoint) -> u32 {
        let diagonal = point.uv.x + point.uv.y;
        match self {
            Self::Cube(_) => 2 * local + u32::from(diagonal < 1.0),
            Self::Patch(Patch { outline: Outline::Square, .. }) => u32::from(diagonal > 1.0),
            _ => local,
        }
    }

    /// The texture coordinates of a point as files and models give them, also where textures are looked up by
    /// others.
    pub fn file_uv(&self, point: &SurfacePoint) -> DVec2 {
        match self {
            Self::Mesh(mesh) => mesh.file_uv(point),
            _ => point.uv,
        }
    }

    /// The point of a hit on primitive `local` of this shape. Without `UV`, texture coordinates and the
    /// tangents along them are left out: on quadrics they cost more than all the rest.
    #[inline(always)]
    pub fn point<const UV: bool>(&self, ray: &Ray, hit: &Hit, local: u32) -> SurfacePoint {
        match self {
            Self::Mesh(mesh) => mesh.point::<UV>(local, hit.u, hit.v),
            Self::Patch(patch) => patch.point::<UV>(hit.u, hit.v),
            Self::Cube(cube) => cube.point::<UV>(local, ray.at(hit.t)),
            Self::Sphere(sphere) => sphere.point::<UV>(ray.at(hit.t)),
            Self::Cylinder(cylinder) => cylinder.point::<UV>(ray.at(hit.t)),
        }
    }

    /// How the unit shading normal changes where a hit on primitive `local` moves along the surface by `dp`,
    /// to first order.
    pub fn normal_change(&self, local: u32, hit: &Hit, point: &SurfacePoint, dp: DVec3) -> DVec3 {
        match self {
            Self::Mesh(mesh) => mesh.normal_change(local, (hit.u, hit.v), dp),
            Self::Patch(_) | Self::Cube(_) => DVec3::ZERO,
            Self::Sphere(sphere) => {
                dp * ((point.p - sphere.centre).dot(point.ns) / (sphere.radius * sphere.radius))
            }
            Self::Cylinder(cylinder) => cylinder.normal_change(dp),
        }
    }

    /// The area in m² of the surface (world).
    pub fn area(&self) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.area(),
            Self::Patch(patch) => patch.area(),
            Self::Cube(cube) => cube.area(),
            Self::Sphere(sphere) => sphere.area(),
            Self::Cylinder(cylinder) => cylinder.area(),
        }
    }

    /// A bound of the rounding error of points on it: that of the numbers they are computed from, which may
    /// be larger than the points themselves.
    #[inline]
    pub fn point_error(&self) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.point_error(),
            Self::Patch(patch) => patch.point_error(),
            Self::Cube(cube) => cube.point_error(),
            Self::Sphere(sphere) => sphere.point_error(),
            Self::Cylinder(cylinder) => cylinder.point_error(),
        }
    }

    /// A point uniform in area, by u in [0, 1)², with its texture coordinates if `UV`. Of meshes only those
    /// that emit have their triangles' areas; see [`Mesh::prepare_sampling`].
    #[inline(always)]
    pub fn sample_area<const UV: bool>(&self, u: DVec2) -> AreaSample {
        match self {
            Self::Mesh(mesh) => mesh.sample_area::<UV>(u),
            Self::Patch(patch) => patch.sample_area::<UV>(u),
            Self::Cube(cube) => cube.sample_area::<UV>(u),
            Self::Sphere(sphere) => sphere.sample_area::<UV>(u),
            Self::Cylinder(cylinder) => cylinder.sample_area(u),
        }
    }

    /// A cone around the normals on the front side (world).
    pub fn normals(&self) -> Cone {
        match self {
            Self::Mesh(mesh) => {
                let normals = (0..mesh.triangles.len() as u32).map(|i| mesh.point::<false>(i, 0.0, 0.0).ng);
                // Triangles without area have none.
                Cone::around(normals.filter(|n| n.is_finite()))
            }
            Self::Patch(patch) => Cone::along(patch.n),
            Self::Cube(cube) => Cone::around(cube.faces().iter().map(|face| face.n)),
            Self::Sphere(_) | Self::Cylinder(_) => Cone::EVERYWHERE,
        }
    }

    /// Points whose convex hull contains the shape.
    pub fn hull(&self) -> Vec<DVec3> {
        match self {
            Self::Mesh(mesh) => mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect(),
            Self::Patch(patch) => patch.corners().to_vec(),
            Self::Cube(cube) => cube.corners(),
            Self::Sphere(_) | Self::Cylinder(_) => corners(self.bounds()).to_vec(),
        }
    }

    /// A ball that contains the shape; for a sphere, the sphere itself.
    pub fn ball(&self) -> Ball {
        match self {
            Self::Sphere(sphere) => Ball { centre: sphere.centre, radius: sphere.radius },
            Self::Cylinder(cylinder) => cylinder.ball(),
            Self::Mesh(mesh) => mesh.ball(),
            Self::Patch(patch) => patch.ball(),
            Self::Cube(cube) => Ball::of_points(cube.corners().into_iter()),
        }
    }

    /// The corners of the world-space bounding box.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Patch(patch) => patch.bounds(),
            Self::Cube(cube) => cube.bounds(),
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Cylinder(cylinder) => cylinder.bounds(),
        }
    }
}

/// `to_world` and `flip_normals`, which every shape has.
fn placement(params: &mut Params) -> Result<(Transform, bool), SceneError> {
    let to_world = params.transform("to_world", "object space to world space")?;
    Ok((to_world, params.boolean("flip_normals", false, "turn the surface inside out")?))
}

/// Refuses a transform whose images of the axes are not orthogonal, or not equally long where they should be:
/// it would shear a quadric into another one.
pub fn require_orthogonal(
    params: &Params,
    axes: [DVec3; 3],
    equal: &[(usize, usize)],
) -> Result<(), SceneError> {
    /// Rotations written with three decimals are meant as rotations.
    const TOLERANCE: f64 = 2e-3;
    let lengths = axes.map(length);
    let sheared = (0..3).any(|i| {
        let j = (i + 1) % 3;
        axes[i].dot(axes[j]).abs() > TOLERANCE * lengths[i] * lengths[j]
    });
    let uneven = equal.iter().any(|&(i, j)| (lengths[i] - lengths[j]).abs() > TOLERANCE * lengths[i]);
    if sheared || uneven {
        let [a, b, c] = lengths;
        let message = if sheared {
            "this cannot be sheared, and its axes are not across one another".to_owned()
        } else {
            format!("this cannot be scaled unevenly, and its axes become {a}, {b} and {c} long")
        };
        let expected = "expected rotation, translation and even scaling, up to two thousandths";
        return Err(params.error("to_world", message, expected));
    }
    Ok(())
}
