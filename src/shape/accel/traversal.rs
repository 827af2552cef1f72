//! The traversal of the tree by a ray.

use super::node::{Leaf, Node, NodeRef};
use super::space::LocalRay;
use super::stack::{Query, TraversalStack};
use super::triangles::{Sheared, Triangles};
use super::{Accel, Search};

/// The arrays that a walk visits.
pub struct Arrays<'a> {
    pub nodes: &'a [Node],
    pub triangles: &'a [Triangles],
    accel: &'a Accel,
}

impl<'a> Arrays<'a> {
    #[inline(always)]
    pub fn new(accel: &'a Accel) -> Self {
        Self { nodes: &accel.nodes, triangles: &accel.triangles, accel }
    }
}

/// The state of a traversal, without the stack: what is indexed cannot be held in registers, nor what is in
/// one structure with it.
pub struct Traversal<'a> {
    pub search: Search<'a>,
    local: LocalRay,
    sheared: Sheared,
    next: NodeRef,
    /// Number of nodes in [`TraversalStack::few`].
    waiting: usize,
}

impl<'a> Traversal<'a> {
    /// `None` if the ray misses the unit cube.
    #[inline(always)]
    pub fn new(accel: &Accel, search: Search<'a>) -> Option<Self> {
        let mut local = accel.space.enter(search.ray)?;
        local.shorten(&accel.space, search.best.t);
        let sheared = Sheared::new(search.ray, accel.near);
        Some(Self { search, local, sheared, next: NodeRef::ROOT, waiting: 0 })
    }

    /// Prefetches the next node or leaf.
    #[inline(always)]
    pub fn prefetch(&self, arrays: &Arrays) {
        self.next.prefetch(arrays);
    }

    /// Visits one node or leaf; returns false when the traversal is over.
    #[inline(always)]
    pub fn step<O: Query>(&mut self, arrays: &Arrays, waiting: &mut TraversalStack<O>) -> bool {
        let best = self.search.best.t;
        if let Some(index) = self.next.as_node() {
            let node = &arrays.nodes[index];
            let (hits, entries) = node.intersect(&self.local);
            if hits != 0 {
                let coming = |child: NodeRef| child.prefetch(arrays);
                self.next = O::enter(waiting, &mut self.waiting, hits, entries, &node.children, coming);
                return true;
            }
        } else {
            match self.next.leaf() {
                Leaf::Triangles(index) => arrays.triangles[index].intersect(&self.sheared, &mut self.search),
                Leaf::Mixed(index) => {
                    let mixed = &arrays.accel.mixed[index];
                    arrays.accel.intersect_mixed::<O>(mixed, &self.sheared, &mut self.search);
                }
            }
        }
        if O::ANY && self.search.found() {
            return false;
        }
        if self.search.best.t < best {
            self.local.shorten(&arrays.accel.space, self.search.best.t);
        }
        match waiting.pop(&mut self.waiting, self.local.limit) {
            Some(node) => {
                self.next = node;
                true
            }
            None => false,
        }
    }
}
