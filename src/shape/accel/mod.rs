//! The acceleration structure: what a ray hits first.
//!
//! A hierarchy of axis-aligned boxes, eight to a node, leads to blocks of four primitives. Boxes are `f32` in
//! coordinates that fill the unit cube whatever the scene's scale and place; primitives are tested in `f64`,
//! so the boxes only have to be safe, not exact. The closest hit is the smallest (distance, primitive
//! number): neither the shape of the tree, nor who built it, nor the order of traversal can change what is
//! found.
//!
//! A handful of primitives needs no tree at all, and a handful of other shapes beside many triangles stays
//! out of theirs.
//!
//! - *Building* (`build`): what there is (`items`), some of it chosen to stay outside the tree (`outside_choice`), thin
//!   triangles cut (`splits`), a binary tree grown from the top (`binned_sah` by `bins` over `boxes`), which
//!   collapses (`collapse`) into nodes of eight, laid out in memory by `layout`.
//! - *Traversal*: one ray (`traversal`, with a `stack` and either question, `any_hit` or `closest_hit`), several
//!   that take turns (`interleaved`), four side by side (`packet`), what is outside the tree (`outside_tree`), groups
//!   (`instances`), and the whole hull of many rays (`shaft`, `hull`).
//! - *Primitives* in `block`s of four: `triangles`, `patches`, `cubes`, `spheres`, `cylinders`.
//! - Coordinates of the unit cube: `space`; of a `node`.

mod any_hit;
mod binned_sah;
mod bins;
mod block;
mod boxes;
mod build;
mod closest_hit;
mod collapse;
mod cubes;
mod cylinders;
mod hull;
mod instances;
mod interleaved;
mod items;
mod layout;
mod node;
mod outside_choice;
mod outside_tree;
mod packet;
mod patches;
mod shaft;
mod space;
mod spheres;
mod splits;
mod stack;
mod traversal;
mod triangles;

use super::Hit;
use crate::math::ray::NO_PRIMITIVE;
use crate::math::{Bounds, Ray};
use crate::pages::Pages;
use any_hit::AnyHit;
use block::{Block, Rays};
use closest_hit::ClosestHit;
use cubes::Cubes;
use cylinders::Cylinders;
pub use instances::Instance;
use node::Node;
use outside_tree::OutsideTree;
use patches::Patches;
pub use shaft::Shaft;
use space::Space;
use spheres::Spheres;
use stack::{Query, TraversalStack};
use traversal::{Arrays, Traversal};
use triangles::{Sheared, Triangles};

/// The leaf of a tree whose primitives are not all triangles.
#[derive(Clone, Debug, Default)]
struct Mixed {
    triangles: Option<u32>,
    patches: Option<u32>,
    cubes: Option<u32>,
    spheres: Option<u32>,
    cylinders: Option<u32>,
    instances: Vec<u32>,
}

/// All primitives of a scene, ready to be met by rays.
pub struct Accel {
    space: Space,
    /// Nodes of the tree; empty if every ray tests all primitives.
    nodes: Pages<Node>,
    /// Whether rays are faster in turns; see [`interleaved`].
    scattered: bool,
    triangles: Pages<Triangles>,
    patches: Vec<Patches>,
    cubes: Vec<Cubes>,
    spheres: Vec<Spheres>,
    cylinders: Vec<Cylinders>,
    mixed: Vec<Mixed>,
    outside_tree: OutsideTree,
    /// Instances of groups; if there are any, there is a tree.
    instances: Vec<Instance>,
    primitives: u32,
    /// The corners of a box around all primitives.
    bounds: Bounds,
    /// Distance from a ray's start within which a triangle's hit is computed again; see [`triangles::NEAR`].
    near: f64,
}

/// A ray, and its best hit so far.
#[derive(Clone, Copy)]
struct Search<'a> {
    ray: &'a Ray,
    best: Hit,
}

impl Search<'_> {
    #[inline(always)]
    fn new(ray: &Ray) -> Search<'_> {
        Search { ray, best: Hit { t: ray.end, u: 0.0, v: 0.0, primitive: NO_PRIMITIVE } }
    }

    /// Takes a hit if it comes before the best: by distance, then by primitive.
    #[inline(always)]
    fn offer(&mut self, t: f64, u: f64, v: f64, primitive: u32) {
        if t < self.best.t || (t == self.best.t && primitive < self.best.primitive && self.found()) {
            self.best = Hit { t, u, v, primitive };
        }
    }

    #[inline(always)]
    fn found(&self) -> bool {
        self.best.primitive != NO_PRIMITIVE
    }

    #[inline(always)]
    fn hit(&self) -> Option<Hit> {
        self.found().then_some(self.best)
    }
}

impl Accel {
    /// The first primitive along the ray, between its start and end.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut search = Search::new(ray);
        self.search::<ClosestHit>(&mut search);
        search.hit()
    }

    /// Whether anything lies between the ray's start and end.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.any(ray).is_some()
    }

    #[inline]
    fn any(&self, ray: &Ray) -> Option<Hit> {
        let mut search = Search::new(ray);
        self.search::<AnyHit>(&mut search);
        search.hit()
    }

    /// The first primitive along each ray; bit for bit what [`Accel::closest`] finds.
    pub fn closest_all(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.search_all::<ClosestHit>(rays, |i, best| hits[i] = best);
    }

    /// Whether anything lies between the start and end of each ray.
    pub fn occluded_all(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.search_all::<AnyHit>(rays, |i, best| occluded[i] = best.is_some());
    }

    #[inline(always)]
    fn search_all<O: Query>(&self, rays: &[Ray], mut report: impl FnMut(usize, Option<Hit>)) {
        if self.nodes.is_empty() {
            // A loop of its own: one with a walk in it leaves no ray in registers.
            return self.try_together::<O>(rays, |i, search| report(i, search.hit()));
        }
        if self.take_turns(rays) {
            let mut searches = Vec::with_capacity(rays.len());
            self.try_together::<O>(rays, |_, search| searches.push(search));
            return self.traverse_in_turns::<O>(&searches, report);
        }
        self.try_together::<O>(rays, |i, mut search| {
            self.search_tree::<O>(&mut search);
            report(i, search.hit());
        });
    }

    /// Whether rays often visit nodes that lie in no near cache.
    pub fn is_scattered(&self) -> bool {
        self.scattered
    }

    /// How many primitives there are.
    pub fn primitives(&self) -> u32 {
        self.primitives
    }

    /// The corners of a box around all primitives; of nothing where there are none.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Bytes that nodes and blocks take, without those of instanced groups.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(&*self.triangles)
            + size_of_val(&*self.patches)
            + size_of_val(&*self.cubes)
            + size_of_val(&*self.spheres)
            + size_of_val(&*self.cylinders)
            + size_of_val(&*self.mixed)
    }

    /// Number of nodes of the tree; 0 if every ray tests all primitives.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Whether some primitives are in no tree, though there is one.
    pub fn tries_beside_tree(&self) -> bool {
        !self.nodes.is_empty() && self.outside_tree.in_packets()
    }

    #[inline(always)]
    fn search<O: Query>(&self, search: &mut Search) {
        if !self.outside_tree.is_empty() {
            self.try_all::<O>(search);
        }
        self.search_tree::<O>(search);
    }

    /// Searches the tree for a hit better than the one found already, if any.
    #[inline]
    fn search_tree<O: Query>(&self, search: &mut Search) {
        if self.nodes.is_empty() || O::ANY && search.found() {
            return;
        }
        let arrays = Arrays::new(self);
        let Some(mut walk) = Traversal::new(self, *search) else { return };
        let mut waiting = TraversalStack::<O>::new();
        while walk.step(&arrays, &mut waiting) {}
        *search = walk.search;
    }

    #[inline(never)]
    fn intersect_mixed<O: Query>(&self, mixed: &Mixed, sheared: &Sheared, search: &mut Search) {
        if let Some(block) = mixed.triangles {
            self.triangles[block as usize].intersect(sheared, search);
        }
        let rays = Rays::alike(search);
        intersect_one(&self.patches, mixed.patches, &rays, search);
        intersect_one(&self.cubes, mixed.cubes, &rays, search);
        intersect_one(&self.spheres, mixed.spheres, &rays, search);
        intersect_one(&self.cylinders, mixed.cylinders, &rays, search);
        for &instance in &mixed.instances {
            self.instances[instance as usize].intersect::<O>(search);
        }
    }
}

#[inline(always)]
fn intersect_one<B: Block>(blocks: &[B], which: Option<u32>, rays: &Rays, search: &mut Search) {
    if let Some(block) = which {
        blocks[block as usize].intersect(rays, search);
    }
}

#[cfg(test)]
mod tests;
