//! Primitives that every ray tests, without a tree: all of a scene of few primitives, or the few others
//! beside many triangles.

use super::block::{Block, Rays};
use super::packet::Packet;
use super::stack::Query;
use super::triangles::Sheared;
use super::{Accel, Search, shaft};
use crate::math::Ray;
use crate::math::ray::Ends;

/// Numbers of blocks of each kind, the first of each, that every ray tests; the others are leaves of the
/// tree.
#[derive(Default)]
pub struct OutsideTree {
    /// How many of the blocks of patches, the first ones, have the scene on both sides.
    pub inner_patches: usize,
    pub patches: usize,
    pub cubes: usize,
    pub spheres: usize,
    pub cylinders: usize,
    /// Blocks of triangles: all, or none.
    pub triangles: usize,
    /// The same primitives, for shafts.
    pub few: shaft::Few,
}

impl OutsideTree {
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.few.primitives.is_empty()
    }

    /// Whether there are primitives that several rays can test together.
    #[inline(always)]
    pub fn in_packets(&self) -> bool {
        self.patches + self.cubes + self.spheres + self.cylinders > 0
    }

    /// The number of blocks of patches that can lie between the ends of a ray.
    #[inline(always)]
    fn patches(&self, on_surfaces: bool) -> usize {
        if on_surfaces { self.inner_patches } else { self.patches }
    }
}

impl Accel {
    /// Tests one ray against all primitives outside the tree. Not inlined: a walk must not share its
    /// registers.
    #[inline(never)]
    pub(super) fn try_all<O: Query>(&self, search: &mut Search) {
        let on_surfaces = O::ANY && search.ray.ends == Ends::OnSurfaces;
        let rays = Rays::alike(search);
        let found =
            try_blocks::<O, _>(&self.patches[..self.outside_tree.patches(on_surfaces)], &rays, search)
                || try_blocks::<O, _>(&self.cubes[..self.outside_tree.cubes], &rays, search)
                || try_blocks::<O, _>(&self.spheres[..self.outside_tree.spheres], &rays, search)
                || try_blocks::<O, _>(&self.cylinders[..self.outside_tree.cylinders], &rays, search);
        if !found {
            self.try_triangles::<O>(search);
        }
    }

    /// Tests many rays against all primitives outside the tree; passes each, in order, with what it has found
    /// to `hand_on`.
    #[inline(always)]
    pub(super) fn try_together<'a, O: Query>(
        &self,
        rays: &'a [Ray],
        mut hand_on: impl FnMut(usize, Search<'a>),
    ) {
        if !self.outside_tree.in_packets() {
            for (i, ray) in rays.iter().enumerate() {
                let mut search = Search::new(ray);
                self.try_triangles::<O>(&mut search);
                hand_on(i, search);
            }
            return;
        }
        for (group, rays) in rays.chunks(Packet::WIDTH).enumerate() {
            let last = rays.len() - 1;
            let mut packet = Packet::new(std::array::from_fn(|i| &rays[i.min(last)]));
            let on_surfaces = O::ANY && rays.iter().all(|ray| ray.ends == Ends::OnSurfaces);
            let patches = &self.patches[..self.outside_tree.patches(on_surfaces)];
            patches.iter().for_each(|block| block.intersect_packet(&mut packet));
            if !(O::ANY && packet.all_found()) {
                let (cubes, spheres) =
                    (&self.cubes[..self.outside_tree.cubes], &self.spheres[..self.outside_tree.spheres]);
                cubes.iter().for_each(|block| block.intersect_packet(&mut packet));
                spheres.iter().for_each(|block| block.intersect_packet(&mut packet));
                let cylinders = &self.cylinders[..self.outside_tree.cylinders];
                cylinders.iter().for_each(|block| block.intersect_packet(&mut packet));
            }
            for (i, ray) in rays.iter().enumerate() {
                let mut search = Search { ray, best: packet.hit(i) };
                self.try_triangles::<O>(&mut search);
                hand_on(group * Packet::WIDTH + i, search);
            }
        }
    }

    /// Tests the triangles, which are not tested in packets.
    #[inline(always)]
    fn try_triangles<O: Query>(&self, search: &mut Search) {
        if self.outside_tree.triangles == 0 || O::ANY && search.found() {
            return;
        }
        let sheared = Sheared::new(search.ray, self.near);
        for block in self.triangles.iter() {
            block.intersect(&sheared, search);
            if O::ANY && search.found() {
                return;
            }
        }
    }
}

/// Tests one ray against blocks of a kind; returns whether the search is over.
#[inline(always)]
fn try_blocks<O: Query, B: Block>(blocks: &[B], rays: &Rays, search: &mut Search) -> bool {
    for block in blocks {
        block.intersect(rays, search);
        if O::ANY && search.found() {
            return true;
        }
    }
    false
}
