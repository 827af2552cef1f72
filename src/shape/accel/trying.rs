//! The choice of primitives that every ray tests, outside the tree, where that is faster.

use super::Instance;
use crate::math::bounds::corners;
use crate::math::ray::position_error;
use crate::shape::{Geometry, Patch};
use std::collections::BTreeSet;

/// Most blocks that every ray tests.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Most blocks in a scene without a tree.
    pub all: usize,
    /// Most blocks of triangles among these.
    pub triangles: usize,
    /// Most blocks beside a tree, which are of all kinds but triangles.
    pub beside: usize,
}

pub const FEW: Limits = Limits { all: 10, triangles: 6, beside: 4 };

/// Kinds of primitives that are tested together.
#[derive(Clone, Copy)]
pub enum Kind {
    InnerPatch,
    /// A patch that the whole scene lies on one side of.
    OuterPatch,
    Cube,
    Sphere,
    Cylinder,
    Triangle,
}

impl Kind {
    pub const COUNT: usize = Self::Triangle as usize + 1;
}

/// Which shapes every ray tests, outside the tree: all that are no meshes.
pub struct Trying {
    /// Indices of the patches that are of [`Kind::OuterPatch`].
    outer: BTreeSet<usize>,
    /// Whether meshes are tested too.
    all: bool,
}

impl Trying {
    /// `None` if nothing should be.
    pub fn decide(shapes: &[&Geometry], instances: &[Instance], limits: Limits) -> Option<Self> {
        let is_patch = |shape: &usize| matches!(shapes[*shape], Geometry::Patch(_));
        let patches: Vec<usize> = (0..shapes.len()).filter(is_patch).collect();
        let blocks = |primitives: usize| primitives.div_ceil(4);
        if blocks(patches.len()) > limits.all.max(limits.beside) {
            return None;
        }
        let outer: BTreeSet<usize> =
            patches.iter().copied().filter(|&p| instances.is_empty() && is_outer(shapes, p)).collect();
        let (mut cubes, mut spheres, mut cylinders, mut triangles) = (0, 0, 0, 0);
        for shape in shapes {
            match shape {
                Geometry::Mesh(mesh) => triangles += mesh.triangles.len(),
                Geometry::Cube(_) => cubes += 1,
                Geometry::Sphere(_) => spheres += 1,
                Geometry::Cylinder(_) => cylinders += 1,
                Geometry::Patch(_) => {}
            }
        }
        let of_patches = blocks(outer.len()) + blocks(patches.len() - outer.len());
        let beside = of_patches + blocks(cubes) + blocks(spheres) + blocks(cylinders);
        let blocks_of_all = beside + blocks(triangles);
        let all =
            instances.is_empty() && blocks_of_all <= limits.all && blocks(triangles) <= limits.triangles;
        (all || beside <= limits.beside).then_some(Self { outer, all })
    }

    /// The kind as which a shape is tested; `None` if it is in the tree.
    pub fn kind(&self, shapes: &[&Geometry], shape: usize) -> Option<Kind> {
        match shapes[shape] {
            Geometry::Patch(_) if self.outer.contains(&shape) => Some(Kind::OuterPatch),
            Geometry::Patch(_) => Some(Kind::InnerPatch),
            Geometry::Cube(_) => Some(Kind::Cube),
            Geometry::Sphere(_) => Some(Kind::Sphere),
            Geometry::Cylinder(_) => Some(Kind::Cylinder),
            Geometry::Mesh(_) => self.all.then_some(Kind::Triangle),
        }
    }
}

/// Whether everything lies on one side of the plane of a patch, as all that is in a room does of its walls.
fn is_outer(shapes: &[&Geometry], patch: usize) -> bool {
    /// Most vertices of a mesh that are looked at; of a larger mesh only the box around it is.
    const MANY: usize = 1000;
    let Geometry::Patch(Patch { centre, n, .. }) = shapes[patch] else { return false };
    let (mut before, mut behind) = (false, false);
    let hull = |shape: &&Geometry| match shape {
        Geometry::Mesh(mesh) if mesh.positions.len() > MANY => corners(mesh.bounds()).to_vec(),
        shape => shape.hull(),
    };
    for corner in shapes.iter().flat_map(hull) {
        let height = n.dot(corner - *centre);
        // What lies nearer than rounding errors lies on the plane.
        let error = 4.0 * (position_error(corner) + position_error(*centre));
        before |= height > error;
        behind |= height < -error;
    }
    !(before && behind)
}
