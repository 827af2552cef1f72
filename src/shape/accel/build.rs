//! From shapes to blocks and boxes.
//!
//! A binary tree is [grown](super::binned_sah) from the top, obvhs tries a few nodes elsewhere (Meister & Bittner
//! 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization"), and [`Plan`] folds it into nodes
//! of eight.

use super::binned_sah::grow;
use super::block::Block;
use super::boxes::Boxes;
use super::collapse::{LEAF, Plan};
use super::interleaved::is_scattered;
use super::items::{Item, Items};
use super::layout::{Layout, MixedLeaf};
use super::node::{Node, NodeRef};
use super::outside_choice::{FEW, Kind, Limits, Trying};
use super::shaft::{Few, Plane};
use super::space::Space;
use super::triangles::{NEAR, Triangles};
use super::{Accel, Instance, Mixed, OutsideTree};
use crate::math::bounds::{around, half_extent};
use crate::math::{Bounds, DVec3};
use crate::pages::Pages;
use crate::shape::{Geometry, Patch};
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use rayon::prelude::*;

/// With more items, leaves are filled while the tree grows: that takes half the memory, and rays are as fast.
/// Fewer are left to the plan, which is better where kinds of shapes meet.
const MANY: usize = 1000;

/// Share of all nodes whose reinsertion elsewhere in the tree is tried. Without, any-hit rays in rooms take a
/// third longer; more gains nothing.
const REINSERTED: f32 = 0.02;

impl Accel {
    /// Numbers the primitives of all shapes in order and arranges them for searching.
    pub fn new(shapes: &[&Geometry]) -> Self {
        Self::with_instances(shapes, vec![])
    }

    /// The same, with instances of other trees; their primitives come after those of the shapes. All together
    /// must be fewer than [`NO_PRIMITIVE`](crate::math::ray::NO_PRIMITIVE).
    pub fn with_instances(shapes: &[&Geometry], instances: Vec<Instance>) -> Self {
        Self::limited(shapes, instances, FEW)
    }

    pub(super) fn limited(shapes: &[&Geometry], mut instances: Vec<Instance>, limits: Limits) -> Self {
        let trying = Trying::decide(shapes, &instances, limits);
        let Items { in_tree, outside_tree, primitives, bounds, of_tree, of_triangles } =
            Items::list(shapes, &mut instances, trying.as_ref());
        // A ground that is far larger than all else must not widen the boxes of a tree that it is not in.
        let inner = if in_tree.is_empty() { bounds } else { of_tree };
        let space = match primitives {
            0 => Space::new((DVec3::ZERO, DVec3::ZERO), 0.0),
            _ => Space::new(inner, half_extent(bounds)),
        };
        let mut accel = Self {
            space,
            nodes: Pages::zeroed(0),
            scattered: false,
            triangles: Pages::zeroed(0),
            patches: vec![],
            cubes: vec![],
            spheres: vec![],
            cylinders: vec![],
            mixed: vec![],
            outside_tree: OutsideTree::default(),
            instances,
            primitives,
            bounds,
            near: NEAR * 2.0 * half_extent(of_triangles).max(0.0),
        };
        accel.keep(shapes, &outside_tree);
        if !in_tree.is_empty() {
            let boxes = Boxes::new(shapes, &accel.instances, &in_tree, &space);
            // An instance is a leaf of its own.
            let whole_leaves = accel.instances.is_empty() && in_tree.len() > MANY;
            let most = if whole_leaves { usize::from(LEAF) } else { 1 };
            let mut binary = grow(boxes.boxes, boxes.items, most);
            ReinsertionOptimizer::default().run(&mut binary, REINSERTED, None);
            let plan = Plan::new(&binary, &boxes.contents);
            accel.arrange(shapes, &in_tree, &plan);
        }
        accel
    }

    /// Stores the primitives outside the tree, by kind, so that blocks are full.
    fn keep(&mut self, shapes: &[&Geometry], outside_tree: &[Vec<Item>; Kind::COUNT]) {
        for kind in [Kind::InnerPatch, Kind::OuterPatch, Kind::Cube, Kind::Sphere, Kind::Cylinder] {
            for block in outside_tree[kind as usize].chunks(4) {
                self.store(shapes, block.iter().copied());
            }
        }
        let triangles = &outside_tree[Kind::Triangle as usize];
        self.triangles = Pages::zeroed(triangles.len().div_ceil(4));
        for (block, items) in self.triangles.iter_mut().zip(triangles.chunks(4)) {
            *block = triangles_of(shapes, items.iter().copied());
        }
        self.outside_tree = OutsideTree {
            inner_patches: outside_tree[Kind::InnerPatch as usize].len().div_ceil(4),
            patches: self.patches.len(),
            cubes: self.cubes.len(),
            spheres: self.spheres.len(),
            cylinders: self.cylinders.len(),
            triangles: self.triangles.len(),
            few: self.few(shapes, &outside_tree.concat()),
        };
    }

    /// Boxes and planes of the primitives outside the tree.
    fn few(&self, shapes: &[&Geometry], items: &[Item]) -> Few {
        let flat = |patch: &Patch| (Some(Plane::new(patch.centre, patch.n)), patch.bounds());
        let primitives: Vec<(u32, (Option<Plane>, Bounds))> = items
            .iter()
            .flat_map(|item| {
                let shape = shapes[item.shape as usize];
                let of_item = match shape {
                    Geometry::Mesh(mesh) => {
                        let corners = mesh.corners(item.local);
                        vec![(Some(Plane::of_corners(corners)), around(corners))]
                    }
                    Geometry::Patch(patch) => vec![flat(patch)],
                    Geometry::Cube(cube) => cube.faces().iter().map(flat).collect(),
                    Geometry::Sphere(_) | Geometry::Cylinder(_) => vec![(None, shape.bounds())],
                };
                (item.primitive..).zip(of_item)
            })
            .collect();
        let mut boxes = vec![Node::empty(); primitives.len().div_ceil(8)];
        for (i, (_, (_, bounds))) in primitives.iter().enumerate() {
            let (lo, hi) = self.space.enclose(bounds.0, bounds.1);
            boxes[i / 8].set(i % 8, lo, hi, NodeRef::EMPTY);
        }
        Few { boxes, primitives: primitives.into_iter().map(|(i, (plane, _))| (i, plane)).collect() }
    }

    /// Makes the nodes and leaves of a plan.
    fn arrange(&mut self, shapes: &[&Geometry], items: &[Item], plan: &Plan) {
        let items_of = |leaf: u32| plan.primitives(leaf).map(|i| items[i as usize]);
        let Layout { nodes, blocks, mixed } = Layout::new(plan);
        self.triangles = Pages::zeroed(blocks.len());
        let filled = self.triangles.par_iter_mut().zip(&blocks).with_min_len(1024);
        filled.for_each(|(block, leaf)| *block = triangles_of(shapes, items_of(*leaf)));
        for MixedLeaf { leaf, triangles } in mixed {
            let mixed = Mixed { triangles, ..self.store(shapes, items_of(leaf)) };
            self.mixed.push(mixed);
        }
        self.nodes = Pages::zeroed(nodes.len());
        let filled = self.nodes.par_iter_mut().zip(&nodes).with_min_len(256);
        filled.for_each(|(node, wide)| *node = wide.node(plan));
        self.scattered = is_scattered(&self.nodes);
    }

    /// Stores up to four items, except triangles; returns where they are.
    fn store(&mut self, shapes: &[&Geometry], items: impl IntoIterator<Item = Item>) -> Mixed {
        let (mut patches, mut cubes, mut spheres, mut cylinders) = (vec![], vec![], vec![], vec![]);
        let mut instances = vec![];
        for item in items {
            match shapes.get(item.shape as usize) {
                None => instances.push(item.shape - shapes.len() as u32),
                Some(Geometry::Mesh(_)) => {}
                Some(Geometry::Patch(patch)) => patches.push((patch, item.primitive)),
                Some(Geometry::Cube(cube)) => cubes.push((cube, item.primitive)),
                Some(Geometry::Sphere(sphere)) => spheres.push((sphere, item.primitive)),
                Some(Geometry::Cylinder(cylinder)) => cylinders.push((cylinder, item.primitive)),
            }
        }
        Mixed {
            triangles: None,
            patches: put(&mut self.patches, &patches),
            cubes: put(&mut self.cubes, &cubes),
            spheres: put(&mut self.spheres, &spheres),
            cylinders: put(&mut self.cylinders, &cylinders),
            instances,
        }
    }
}

/// Stores a block of these items, if there are any; returns its index.
fn put<B: Block>(blocks: &mut Vec<B>, items: &[(&B::Shape, u32)]) -> Option<u32> {
    let place = blocks.len() as u32;
    (!items.is_empty()).then(|| {
        blocks.push(B::new(items));
        place
    })
}

/// A block of the triangles among up to four items.
fn triangles_of(shapes: &[&Geometry], items: impl IntoIterator<Item = Item>) -> Triangles {
    let mut block = Triangles::empty();
    let mut lane = 0;
    for item in items {
        if let Some(Geometry::Mesh(mesh)) = shapes.get(item.shape as usize) {
            if block.holds(item.primitive) {
                continue;
            }
            let corners = mesh.triangles[item.local as usize].map(|i| mesh.positions[i as usize]);
            block.set(lane, corners, item.primitive);
            lane += 1;
        }
    }
    block
}
