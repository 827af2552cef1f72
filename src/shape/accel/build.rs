//! From shapes to blocks and boxes.
//!
//! obvhs builds a binary tree (PLOC with reinsertion: Meister & Bittner 2018, 2022); it is folded into nodes of eight by opening
//! the child of largest area until the node is full.

use super::node::{Node, NodeRef};
use super::patches::Patches;
use super::space::Space;
use super::spheres::Spheres;
use super::triangles::Triangles;
use super::{Accel, Instance, Mixed};
use crate::math::DVec3;
use crate::math::ray::position_error;
use crate::shape::{Geometry, Patch};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

/// Up to this many blocks are faster tried than searched.
const FEW: usize = 8;

/// A primitive by shape and place in it, or an instance.
#[derive(Clone, Copy)]
struct Item {
    /// Instances are counted after the shapes.
    shape: u32,
    local: u32,
    primitive: u32,
}

impl Accel {
    /// Numbers the primitives of all shapes in order and arranges them for searching.
    pub fn new(shapes: &[&Geometry]) -> Self {
        Self::with_instances(shapes, vec![])
    }

    /// The same, with instances of other trees; their primitives come after those of the shapes. All together must
    /// be fewer than [`Ray::FREE`](crate::math::Ray::FREE).
    pub fn with_instances(shapes: &[&Geometry], mut instances: Vec<Instance>) -> Self {
        let mut items = vec![];
        let mut bounds = (DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY));
        for (shape, geometry) in shapes.iter().enumerate() {
            let (lo, hi) = geometry.bounds();
            bounds = (bounds.0.min(lo), bounds.1.max(hi));
            for local in 0..geometry.primitives() {
                items.push(Item { shape: shape as u32, local, primitive: items.len() as u32 });
            }
        }
        let mut primitives = items.len() as u32;
        for (i, instance) in instances.iter_mut().enumerate().filter(|(_, i)| i.primitives() > 0) {
            let (lo, hi) = instance.bounds();
            bounds = (bounds.0.min(lo), bounds.1.max(hi));
            items.push(Item { shape: (shapes.len() + i) as u32, local: 0, primitive: primitives });
            primitives = instance.number(primitives);
        }
        let space = if items.is_empty() {
            Space::new(DVec3::ZERO, DVec3::ZERO)
        } else {
            Space::new(bounds.0, bounds.1)
        };
        let mut accel = Self {
            space,
            nodes: vec![],
            triangles: vec![],
            patches: vec![],
            inner_patches: 0,
            spheres: vec![],
            cylinders: vec![],
            mixed: vec![],
            instances,
            primitives,
            bounds,
        };
        // Sorted by kind, so that blocks are full.
        let kind = |item: &Item| match shapes[item.shape as usize] {
            Geometry::Mesh(_) => 0,
            Geometry::Patch(_) => 1,
            Geometry::Sphere(_) => 2,
            Geometry::Cylinder(_) => 3,
        };
        let of_kind = |k: i32| items.iter().filter(|i| kind(i) == k).copied().collect::<Vec<Item>>();
        if accel.instances.is_empty() && items.len() <= 4 * FEW {
            let [triangles, patches, spheres, cylinders] = [0, 1, 2, 3].map(of_kind);
            let (outer, inner) = patches.iter().partition(|patch| is_outer(shapes, patch.shape as usize));
            let kinds: [Vec<Item>; 5] = [inner, outer, triangles, spheres, cylinders];
            if kinds.iter().map(|items| items.len().div_ceil(4)).sum::<usize>() <= FEW {
                for block in kinds.iter().flat_map(|items| items.chunks(4)) {
                    accel.add(shapes, block);
                }
                accel.inner_patches = kinds[0].len().div_ceil(4);
                return accel;
            }
        }
        let boxes: Vec<Aabb> = items
            .iter()
            .map(|item| {
                let (lo, hi) = match shapes.get(item.shape as usize) {
                    Some(shape) => primitive_bounds(shape, item.local),
                    None => accel.instances[item.shape as usize - shapes.len()].bounds(),
                };
                let (lo, hi) = space.enclose(lo, hi);
                Aabb::new(Vec3A::from_array(lo), Vec3A::from_array(hi))
            })
            .collect();
        let parameters = BvhBuildParams {
            max_prims_per_leaf: 4,
            collapse_traversal_cost: 3.0,
            ..BvhBuildParams::medium_build()
        };
        let binary = build_bvh2(&boxes, parameters, &mut Default::default());
        accel.fold(shapes, &items, &binary, 0);
        accel
    }

    /// Makes the node for binary node `index` and everything below it.
    fn fold(&mut self, shapes: &[&Geometry], items: &[Item], binary: &Bvh2, index: usize) -> NodeRef {
        let mut waiting = vec![(index, self.new_node())];
        let root = NodeRef::node(waiting[0].1);
        while let Some((index, to)) = waiting.pop() {
            let mut open = children(binary, index);
            while open.len() < 8 {
                let area = |i: &usize| binary.nodes[*i].aabb().half_area();
                let inner = (0..open.len()).filter(|&i| !binary.nodes[open[i]].is_leaf());
                let Some(largest) = inner.max_by(|&a, &b| area(&open[a]).total_cmp(&area(&open[b]))) else {
                    break;
                };
                let opened = open.remove(largest);
                open.extend(children(binary, opened));
            }
            for (slot, child) in open.into_iter().enumerate() {
                let node = &binary.nodes[child];
                let target = if node.is_leaf() {
                    let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                    let leaf: Vec<Item> =
                        binary.primitive_indices[range].iter().map(|&i| items[i as usize]).collect();
                    self.add(shapes, &leaf)
                } else {
                    let inner = self.new_node();
                    waiting.push((child, inner));
                    NodeRef::node(inner)
                };
                let aabb = node.aabb();
                self.nodes[to].set(slot, aabb.min.to_array(), aabb.max.to_array(), target);
            }
        }
        root
    }

    fn new_node(&mut self) -> usize {
        self.nodes.push(Node::empty());
        self.nodes.len() - 1
    }

    /// Stores up to four primitives as blocks.
    fn add(&mut self, shapes: &[&Geometry], items: &[Item]) -> NodeRef {
        let mut triangles = Triangles::empty();
        let mut triangle_count = 0;
        let (mut patches, mut spheres) = (vec![], vec![]);
        let mut instances = vec![];
        let first_cylinder = self.cylinders.len() as u32;
        for item in items {
            let Some(shape) = shapes.get(item.shape as usize) else {
                instances.push(item.shape - shapes.len() as u32);
                continue;
            };
            match shape {
                Geometry::Mesh(mesh) => {
                    let corners = mesh.triangles[item.local as usize].map(|i| mesh.positions[i as usize]);
                    triangles.set(triangle_count, corners, item.primitive);
                    triangle_count += 1;
                }
                Geometry::Patch(patch) => patches.push((patch, item.primitive)),
                Geometry::Sphere(sphere) => spheres.push((sphere, item.primitive)),
                Geometry::Cylinder(cylinder) => self.cylinders.push((*cylinder, item.primitive)),
            }
        }
        let cylinders = first_cylinder..self.cylinders.len() as u32;
        let mut mixed = Mixed { cylinders, instances, ..Mixed::default() };
        if triangle_count > 0 {
            mixed.triangles = Some(self.triangles.len() as u32);
            self.triangles.push(triangles);
        }
        if !patches.is_empty() {
            mixed.patches = Some(self.patches.len() as u32);
            self.patches.push(Patches::new(&patches));
        }
        if !spheres.is_empty() {
            mixed.spheres = Some(self.spheres.len() as u32);
            self.spheres.push(Spheres::new(&spheres));
        }
        if triangle_count == items.len() {
            return NodeRef::triangles(self.triangles.len() - 1);
        }
        self.mixed.push(mixed);
        NodeRef::mixed(self.mixed.len() - 1)
    }
}

/// Whether everything lies on one side of the plane of a patch, as all that is in a room does of its walls.
fn is_outer(shapes: &[&Geometry], patch: usize) -> bool {
    let Geometry::Patch(Patch { centre, n, .. }) = shapes[patch] else { return false };
    let (mut before, mut behind) = (false, false);
    for corner in shapes.iter().flat_map(|shape| shape.hull()) {
        let height = n.dot(corner - *centre);
        // What lies nearer than rounding errors lies on the plane.
        let error = 4.0 * (position_error(corner) + position_error(*centre));
        before |= height > error;
        behind |= height < -error;
    }
    !(before && behind)
}

/// The children of a binary node; a tree that is one leaf is its own child.
fn children(binary: &Bvh2, index: usize) -> Vec<usize> {
    let node = &binary.nodes[index];
    if node.is_leaf() { vec![index] } else { vec![node.first_index as usize, node.first_index as usize + 1] }
}

fn primitive_bounds(geometry: &Geometry, local: u32) -> (DVec3, DVec3) {
    let Geometry::Mesh(mesh) = geometry else { return geometry.bounds() };
    let [a, b, c] = mesh.triangles[local as usize].map(|i| {
        let p = mesh.positions[i as usize];
        DVec3::new(p[0] as f64, p[1] as f64, p[2] as f64)
    });
    (a.min(b).min(c), a.max(b).max(c))
}
