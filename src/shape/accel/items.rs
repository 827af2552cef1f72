//! The list of what is searched, in the tree and beside it.

use super::Instance;
use super::outside_choice::{Kind, Trying};
use crate::math::Bounds;
use crate::math::bounds::{NOTHING, union};
use crate::pages::Pages;
use crate::shape::{Cube, Geometry};
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

/// Fewest items of a shape that one thread lists.
const MANY: usize = 1 << 14;

/// A primitive by shape and place in it, all faces of a cube, or an instance.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Item {
    /// Index of the shape; instances are counted after the shapes.
    pub shape: u32,
    pub local: u32,
    /// Number of the first primitive among those of the whole scene.
    pub primitive: u32,
}

/// The items of one shape, or one instance.
struct Run {
    first: Item,
    items: usize,
    /// Primitives of an item.
    together: u32,
}

impl Run {
    fn item(&self, i: usize) -> Item {
        let before = i as u32 * self.together;
        Item { local: before, primitive: self.first.primitive + before, ..self.first }
    }
}

/// All items of a scene.
pub struct Items {
    /// In large pages, for leaves look them up all over.
    pub in_tree: Pages<Item>,
    /// What every ray tests, by kind.
    pub outside_tree: [Vec<Item>; Kind::COUNT],
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
            in_tree: Pages::zeroed(0),
            outside_tree: Default::default(),
            primitives: 0,
            bounds: NOTHING,
            of_tree: NOTHING,
            of_triangles: NOTHING,
        };
        let mut in_tree = vec![];
        for (shape, geometry) in shapes.iter().enumerate() {
            let run = items.number(shape as u32, geometry);
            match trying.and_then(|trying| trying.kind(shapes, shape)) {
                Some(kind) => items.outside_tree[kind as usize].extend((0..run.items).map(|i| run.item(i))),
                None => {
                    items.of_tree = union(items.of_tree, geometry.bounds());
                    in_tree.push(run);
                }
            }
        }
        for (i, instance) in instances.iter_mut().enumerate().filter(|(_, i)| i.primitives() > 0) {
            items.bounds = union(items.bounds, instance.bounds());
            items.of_tree = union(items.of_tree, instance.bounds());
            let first = Item { shape: (shapes.len() + i) as u32, local: 0, primitive: items.primitives };
            in_tree.push(Run { first, items: 1, together: 0 });
            items.primitives = instance.number(items.primitives);
        }
        items.in_tree = listed(&in_tree);
        items
    }

    /// Numbers the primitives of a shape.
    fn number(&mut self, shape: u32, geometry: &Geometry) -> Run {
        let bounds = geometry.bounds();
        self.bounds = union(self.bounds, bounds);
        if let Geometry::Mesh(_) = geometry {
            self.of_triangles = union(self.of_triangles, bounds);
        }
        let together = if let Geometry::Cube(_) = geometry { Cube::FACES } else { 1 };
        let first = Item { shape, local: 0, primitive: self.primitives };
        self.primitives += geometry.primitives();
        Run { first, items: (geometry.primitives() / together) as usize, together }
    }
}

/// The items of all runs.
fn listed(runs: &[Run]) -> Pages<Item> {
    let mut items = Pages::zeroed(runs.iter().map(|run| run.items).sum());
    let mut rest = &mut items[..];
    for run in runs {
        let (of_run, behind) = rest.split_at_mut(run.items);
        let filled = of_run.par_iter_mut().enumerate().with_min_len(MANY);
        filled.for_each(|(i, item)| *item = run.item(i));
        rest = behind;
    }
    items
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Transform};
    use crate::shape::accel::Accel;
    use crate::shape::mesh_data::MeshData;
    use crate::shape::{Mesh, Normals, Sphere};
    use std::sync::Arc;

    fn mesh(triangles: usize) -> Geometry {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let data = MeshData { positions, triangles: vec![[0, 1, 2]; triangles], ..MeshData::default() };
        Geometry::Mesh(Mesh::new(data, &Transform::IDENTITY, Normals::OF_FACES))
    }

    #[test]
    fn items_are_numbered_as_one_by_one() {
        let place = Transform::IDENTITY;
        let shapes = [
            mesh(0),
            Geometry::Cube(Cube::new(&place, false)),
            mesh(2 * MANY + 3),
            Geometry::Cube(Cube::new(&place, false)),
            Geometry::Sphere(Sphere::new(&place, DVec3::ZERO, 1.0, false)),
            mesh(1),
        ];
        let refs: Vec<&Geometry> = shapes.iter().collect();
        let member = mesh(5);
        let instance = || Instance::new(Arc::new(Accel::new(&[&member])), place);
        let items = Items::list(&refs, &mut [instance(), instance()], None);
        let mut expected = vec![];
        let mut primitive = 0;
        for (shape, geometry) in (0..).zip(&shapes) {
            let together = if let Geometry::Cube(_) = geometry { 6 } else { 1 };
            for local in (0..geometry.primitives()).step_by(together as usize) {
                expected.push((shape, local, primitive));
                primitive += together;
            }
        }
        expected.extend([(6, 0, primitive), (7, 0, primitive + 5)]);
        let listed: Vec<_> =
            items.in_tree.iter().map(|item| (item.shape, item.local, item.primitive)).collect();
        assert!(listed == expected);
        assert_eq!(items.primitives, primitive + 10);
    }
}
