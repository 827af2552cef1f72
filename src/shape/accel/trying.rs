//! What is faster tried than searched.

use super::Instance;
use crate::math::bounds::corners;
use crate::math::ray::position_error;
use crate::shape::{Geometry, Patch};
use std::collections::BTreeSet;

/// How much is tried at most.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Blocks in a scene that has no tree,
    pub all: usize,
    /// of which so many of triangles.
    pub triangles: usize,
    /// Blocks of all but triangles beside a tree.
    pub beside: usize,
}

pub const FEW: Limits = Limits { all: 10, triangles: 6, beside: 4 };

/// What is tried together.
#[derive(Clone, Copy)]
pub enum Kind {
    InnerPatch,
    /// Everything lies on one side of it.
    OuterPatch,
    Cube,
    Sphere,
    Cylinder,
    Triangle,
}

impl Kind {
    pub const COUNT: usize = Self::Triangle as usize + 1;
}

/// Which shapes are tried for every ray, and not searched: all that are no meshes.
pub struct Trying {
    /// Of the patches these.
    outer: BTreeSet<usize>,
    /// And meshes.
    all: bool,
}

impl Trying {
    /// `None` where nothing is.
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

    /// With what a shape is tried, if it is.
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
    /// Of a mesh with more vertices only the box around it is looked at.
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
