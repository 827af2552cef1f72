//! The list of what is searched, in the tree and beside it.

use super::Instance;
use super::trying::{Kind, Trying};
use crate::math::Bounds;
use crate::math::bounds::{NOTHING, union};
use crate::shape::{Cube, Geometry};

/// A primitive by shape and place in it, all faces of a cube, or an instance.
#[derive(Clone, Copy)]
pub struct Item {
    /// Index of the shape; instances are counted after the shapes.
    pub shape: u32,
    pub local: u32,
    /// Number of the first primitive among those of the whole scene.
    pub primitive: u32,
}

/// All items of a scene.
pub struct Items {
    pub in_tree: Vec<Item>,
    /// What every ray tests, by kind.
    pub tried: [Vec<Item>; Kind::COUNT],
    /// How many primitives there are.
    pub primitives: u32,
    /// World bounds of everything, of what the tree holds, and of meshes.
    pub bounds: Bounds,
    pub of_tree: Bounds,
    pub of_triangles: Bounds,
}

impl Items {
    /// Numbers the primitives of all shapes in order, then those of the instances, which are told their numbers.
    pub fn list(shapes: &[&Geometry], instances: &mut [Instance], trying: Option<&Trying>) -> Self {
        let mut items = Self {
            in_tree: Vec::with_capacity(shapes.iter().map(|shape| shape.primitives() as usize).sum()),
            tried: Default::default(),
            primitives: 0,
            bounds: NOTHING,
            of_tree: NOTHING,
            of_triangles: NOTHING,
        };
        for (shape, geometry) in shapes.iter().enumerate() {
            items.push_shape(shape as u32, geometry, trying.and_then(|trying| trying.kind(shapes, shape)));
        }
        for (i, instance) in instances.iter_mut().enumerate().filter(|(_, i)| i.primitives() > 0) {
            items.bounds = union(items.bounds, instance.bounds());
            items.of_tree = union(items.of_tree, instance.bounds());
            let shape = (shapes.len() + i) as u32;
            items.in_tree.push(Item { shape, local: 0, primitive: items.primitives });
            items.primitives = instance.number(items.primitives);
        }
        items
    }

    /// `tried` is the kind of a shape that is kept out of the tree.
    fn push_shape(&mut self, shape: u32, geometry: &Geometry, tried: Option<Kind>) {
        let bounds = geometry.bounds();
        self.bounds = union(self.bounds, bounds);
        if let Geometry::Mesh(_) = geometry {
            self.of_triangles = union(self.of_triangles, bounds);
        }
        let list = match tried {
            Some(kind) => &mut self.tried[kind as usize],
            None => {
                self.of_tree = union(self.of_tree, bounds);
                &mut self.in_tree
            }
        };
        let together = if let Geometry::Cube(_) = geometry { Cube::FACES } else { 1 };
        for local in (0..geometry.primitives()).step_by(together as usize) {
            list.push(Item { shape, local, primitive: self.primitives });
            self.primitives += together;
        }
    }
}
