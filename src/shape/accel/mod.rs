//! What a ray meets first.
//!
//! A hierarchy of axis-aligned boxes, eight to a node, leads to blocks of four primitives. Boxes are `f32` in
//! coordinates that fill the unit cube whatever the scene's scale and place; primitives are tested in `f64`,
//! so the boxes only have to be safe, not exact. The closest hit is the smallest (distance, primitive
//! number): neither the shape of the tree, nor who built it, nor the order of traversal can change what is
//! found.
//!
//! A handful of primitives needs no tree at all.

mod bins;
mod build;
mod fold;
mod grow;
mod hull;
mod instances;
mod node;
mod packet;
mod pages;
mod patches;
mod pile;
mod shaft;
mod space;
mod spheres;
mod splits;
mod stack;
mod triangles;
mod turns;
mod waiting;
mod walk;

use super::{Cylinder, Hit};
use crate::math::ray::Ends;
use crate::math::simd::F64x4;
use crate::math::{Bounds, Ray};
pub use instances::Instance;
use node::Node;
use packet::Packet;
use pages::Pages;
use patches::Patches;
use pile::Pile;
pub use shaft::Shaft;
use space::Space;
use spheres::Spheres;
use stack::Stack;
use triangles::{Sheared, Triangles};
use waiting::Waiting;
use walk::{View, Walk};

/// The leaf of a tree whose primitives are not all triangles.
#[derive(Clone, Debug, Default)]
struct Mixed {
    triangles: Option<u32>,
    patches: Option<u32>,
    spheres: Option<u32>,
    cylinders: std::ops::Range<u32>,
    instances: Vec<u32>,
}

/// All primitives of a scene, ready to be met by rays.
pub struct Accel {
    space: Space,
    /// Empty where all blocks are simply tried.
    nodes: Pages<Node>,
    /// Whether rays had better take turns.
    scattered: bool,
    triangles: Pages<Triangles>,
    patches: Vec<Patches>,
    /// The first so many blocks of patches have the scene on both sides. Known only where there is no tree.
    inner_patches: usize,
    spheres: Vec<Spheres>,
    cylinders: Vec<(Cylinder, u32)>,
    mixed: Vec<Mixed>,
    few: shaft::Few,
    /// Where there are any, there is a tree.
    instances: Vec<Instance>,
    primitives: u32,
    /// The corners of a box around all.
    bounds: Bounds,
    /// How near a triangle is looked at again.
    near: f64,
}

/// The best hit so far, and the primitive that cannot be met again.
#[derive(Clone, Copy)]
struct Search<'a> {
    ray: &'a Ray,
    best: Hit,
}

impl Search<'_> {
    const NONE: u32 = u32::MAX;

    #[inline(always)]
    fn new(ray: &Ray) -> Search<'_> {
        Search { ray, best: Hit { t: ray.end, u: 0.0, v: 0.0, primitive: Self::NONE } }
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
        self.best.primitive != Self::NONE
    }
}

/// A ray in every lane.
struct Rays {
    origin: [F64x4; 3],
    direction: [F64x4; 3],
    start: F64x4,
}

impl Rays {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array().map(F64x4::splat),
            direction: ray.direction.to_array().map(F64x4::splat),
            start: F64x4::splat(ray.start),
        }
    }
}

impl Accel {
    /// The first primitive along the ray, between its start and end.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut search = Search::new(ray);
        self.search::<false>(&mut search);
        search.found().then_some(search.best)
    }

    /// Whether anything lies between the ray's start and end.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.any(ray).is_some()
    }

    #[inline]
    fn any(&self, ray: &Ray) -> Option<Hit> {
        let mut search = Search::new(ray);
        self.search::<true>(&mut search);
        search.found().then_some(search.best)
    }

    /// The first primitive along each ray; bit for bit what [`Accel::closest`] finds.
    pub fn closest_all(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.search_all::<false>(rays, |i, best| hits[i] = best);
    }

    /// Whether anything lies between the start and end of each ray.
    pub fn occluded_all(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.search_all::<true>(rays, |i, best| occluded[i] = best.is_some());
    }

    #[inline(always)]
    fn search_all<const ANY: bool>(&self, rays: &[Ray], mut report: impl FnMut(usize, Option<Hit>)) {
        let in_packets = self.nodes.is_empty() && !(self.patches.is_empty() && self.spheres.is_empty());
        if self.take_turns(rays) {
            return if ANY {
                self.traverse_in_turns::<Pile>(rays, report)
            } else {
                self.traverse_in_turns::<Stack>(rays, report)
            };
        }
        if !in_packets {
            for (i, ray) in rays.iter().enumerate() {
                report(i, if ANY { self.any(ray) } else { self.closest(ray) });
            }
            return;
        }
        let rest = !(self.cylinders.is_empty() && self.triangles.is_empty());
        for (group, rays) in rays.chunks(Packet::WIDTH).enumerate() {
            let last = rays.len() - 1;
            let mut packet = Packet::new(std::array::from_fn(|i| &rays[i.min(last)]));
            let inner = ANY && rays.iter().all(|ray| ray.ends == Ends::OnSurfaces);
            for block in if inner { &self.patches[..self.inner_patches] } else { &self.patches } {
                block.intersect_packet(&mut packet);
            }
            if !(ANY && packet.all_found()) {
                for block in &self.spheres {
                    block.intersect_packet(&mut packet);
                }
            }
            for (i, ray) in rays.iter().enumerate() {
                let mut search = Search { ray, best: packet.hit(i) };
                if rest {
                    self.try_rest::<ANY>(&mut search);
                }
                report(group * Packet::WIDTH + i, search.found().then_some(search.best));
            }
        }
    }

    /// Whether much of what rays visit lies far away in memory.
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
            + size_of_val(&*self.spheres)
            + size_of_val(&*self.cylinders)
            + size_of_val(&*self.mixed)
    }

    /// Nodes of the tree; none where the primitives are simply tried.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    #[inline(always)]
    fn search<const ANY: bool>(&self, search: &mut Search) {
        if self.nodes.is_empty() {
            self.try_all::<ANY>(search);
        } else if ANY {
            self.traverse::<Pile>(search);
        } else {
            self.traverse::<Stack>(search);
        }
    }

    #[inline(always)]
    fn try_all<const ANY: bool>(&self, search: &mut Search) {
        let rays = Rays::new(search.ray);
        let inner = ANY && search.ray.ends == Ends::OnSurfaces;
        for block in if inner { &self.patches[..self.inner_patches] } else { &self.patches } {
            block.intersect(&rays, search);
            if ANY && search.found() {
                return;
            }
        }
        for block in &self.spheres {
            block.intersect(&rays, search);
            if ANY && search.found() {
                return;
            }
        }
        self.try_rest::<ANY>(search);
    }

    /// Tries what is not tried in packets.
    #[inline(always)]
    fn try_rest<const ANY: bool>(&self, search: &mut Search) {
        if ANY && search.found() {
            return;
        }
        for cylinder in &self.cylinders {
            intersect_cylinder(cylinder, search);
            if ANY && search.found() {
                return;
            }
        }
        if !self.triangles.is_empty() {
            let sheared = Sheared::new(search.ray, self.near);
            for block in self.triangles.iter() {
                block.intersect(&sheared, search);
                if ANY && search.found() {
                    return;
                }
            }
        }
    }

    #[inline(always)]
    fn traverse<W: Waiting>(&self, search: &mut Search) {
        let view = View::new(self);
        let Some(mut walk) = Walk::new(self, *search) else { return };
        let mut waiting = W::new();
        while walk.step(&view, &mut waiting) {}
        *search = walk.search;
    }

    #[inline(never)]
    fn intersect_mixed<const ANY: bool>(&self, mixed: &Mixed, sheared: &Sheared, search: &mut Search) {
        if let Some(block) = mixed.triangles {
            self.triangles[block as usize].intersect(sheared, search);
        }
        if let Some(block) = mixed.patches {
            self.patches[block as usize].intersect(&Rays::new(search.ray), search);
        }
        if let Some(block) = mixed.spheres {
            self.spheres[block as usize].intersect(&Rays::new(search.ray), search);
        }
        for cylinder in &self.cylinders[mixed.cylinders.start as usize..mixed.cylinders.end as usize] {
            intersect_cylinder(cylinder, search);
        }
        for &instance in &mixed.instances {
            self.instances[instance as usize].intersect::<ANY>(search);
        }
    }
}

fn intersect_cylinder((cylinder, primitive): &(Cylinder, u32), search: &mut Search) {
    // The end is open: a tie with the best hit must still be offered, to be decided by number.
    let end = search.best.t.next_up();
    if let Some(t) = cylinder.intersect(search.ray, search.ray.from == *primitive, end) {
        search.offer(t, 0.0, 0.0, *primitive);
    }
}

#[cfg(test)]
mod tests;
