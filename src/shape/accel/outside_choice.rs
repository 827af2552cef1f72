//! The choice of primitives that every ray tests, outside the tree, where that is faster.

use super::Instance;
use crate::math::bounds::{NOTHING, corners, half_extent, union};
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

/// Which shapes every ray tests, outside the tree.
pub struct Trying {
    /// Indices of the patches that are of [`Kind::OuterPatch`].
    outer: BTreeSet<usize>,
    which: Which,
}

enum Which {
    All,
    NoMeshes,
    Only(BTreeSet<usize>),
}

impl Trying {
    /// `None` if nothing should be.
    pub fn decide(shapes: &[&Geometry], instances: &[Instance], limits: Limits) -> Option<Self> {
        let is_patch = |shape: &usize| matches!(shapes[*shape], Geometry::Patch(_));
        let patches: Vec<usize> = (0..shapes.len()).filter(is_patch).collect();
        let outer_of = |patches: &[usize]| -> BTreeSet<usize> {
            patches.iter().copied().filter(|&p| instances.is_empty() && is_outer(shapes, p)).collect()
        };
        let blocks = |primitives: usize| primitives.div_ceil(4);
        if blocks(patches.len()) <= limits.all.max(limits.beside) {
            let outer = outer_of(&patches);
            let count = |is_such: fn(&Geometry) -> bool| shapes.iter().filter(|s| is_such(s)).count();
            let of_patches = blocks(outer.len()) + blocks(patches.len() - outer.len());
            let beside = of_patches
                + blocks(count(|shape| matches!(shape, Geometry::Cube(_))))
                + blocks(count(|shape| matches!(shape, Geometry::Sphere(_))))
                + blocks(count(|shape| matches!(shape, Geometry::Cylinder(_))));
            let triangles = blocks(shapes.iter().map(|shape| triangles(shape)).sum());
            if instances.is_empty() && beside + triangles <= limits.all && triangles <= limits.triangles {
                return Some(Self { outer, which: Which::All });
            }
            if beside <= limits.beside {
                return Some(Self { outer, which: Which::NoMeshes });
            }
        }
        let vast = vast(shapes, instances, limits.beside);
        let patches: Vec<usize> = vast.iter().copied().filter(is_patch).collect();
        (!vast.is_empty()).then(|| Self { outer: outer_of(&patches), which: Which::Only(vast) })
    }

    /// The kind as which a shape is tested; `None` if it is in the tree.
    pub fn kind(&self, shapes: &[&Geometry], shape: usize) -> Option<Kind> {
        let tried = match &self.which {
            Which::All => true,
            Which::NoMeshes => !matches!(shapes[shape], Geometry::Mesh(_)),
            Which::Only(vast) => vast.contains(&shape),
        };
        tried.then(|| match shapes[shape] {
            Geometry::Patch(_) if self.outer.contains(&shape) => Kind::OuterPatch,
            Geometry::Patch(_) => Kind::InnerPatch,
            Geometry::Cube(_) => Kind::Cube,
            Geometry::Sphere(_) => Kind::Sphere,
            Geometry::Cylinder(_) => Kind::Cylinder,
            Geometry::Mesh(_) => Kind::Triangle,
        })
    }
}

fn triangles(shape: &Geometry) -> usize {
    if let Geometry::Mesh(mesh) = shape { mesh.triangles.len() } else { 0 }
}

/// The shapes, but for meshes, beside which all others are tiny: grounds and skies, which would make the boxes
/// of a tree coarse that must hold them. No more than so many blocks, one of each.
fn vast(shapes: &[&Geometry], instances: &[Instance], most_blocks: usize) -> BTreeSet<usize> {
    /// How many times as large as all others together. Boxes are widened by 2⁻²¹ of what a tree holds.
    const TIMES: f64 = 256.0;
    let (meshes, mut others): (Vec<usize>, Vec<usize>) =
        (0..shapes.len()).partition(|&shape| matches!(shapes[shape], Geometry::Mesh(_)));
    others.sort_by(|a, b| half_extent(shapes[*a].bounds()).total_cmp(&half_extent(shapes[*b].bounds())));
    let in_tree = meshes.iter().map(|&shape| shapes[shape].bounds());
    let in_tree = in_tree.chain(instances.iter().filter(|i| i.primitives() > 0).map(Instance::bounds));
    let mut smaller = in_tree.fold(NOTHING, union);
    for (place, &shape) in others.iter().enumerate() {
        let bounds = shapes[shape].bounds();
        let is_vast = smaller.0.x <= smaller.1.x && half_extent(bounds) > TIMES * half_extent(smaller);
        if is_vast && others.len() - place <= most_blocks {
            return others[place..].iter().copied().collect();
        }
        smaller = union(smaller, bounds);
    }
    BTreeSet::new()
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
