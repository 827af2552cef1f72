//! The traversal of the tree by a ray.

use super::node::{Leaf, Node, NodeRef};
use super::space::LocalRay;
use super::triangles::{Sheared, Triangles};
use super::waiting::{Order, Waiting};
use super::{Accel, Search};

/// The arrays that a walk visits.
pub struct View<'a> {
    pub nodes: &'a [Node],
    pub triangles: &'a [Triangles],
    accel: &'a Accel,
}

impl<'a> View<'a> {
    #[inline(always)]
    pub fn new(accel: &'a Accel) -> Self {
        Self { nodes: &accel.nodes, triangles: &accel.triangles, accel }
    }
}

/// The state of a traversal, without the stack: what is indexed cannot be held in registers, nor what is in
/// one structure with it.
pub struct Walk<'a> {
    pub search: Search<'a>,
    local: LocalRay,
    sheared: Sheared,
    next: NodeRef,
    /// Number of nodes in [`Waiting::few`].
    waiting: usize,
}

impl<'a> Walk<'a> {
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
    pub fn prefetch(&self, view: &View) {
        self.next.prefetch(view);
    }

    /// Visits one node or leaf; returns false when the traversal is over.
    #[inline(always)]
    pub fn step<O: Order>(&mut self, view: &View, waiting: &mut Waiting<O>) -> bool {
        let best = self.search.best.t;
        if let Some(index) = self.next.as_node() {
            let node = &view.nodes[index];
            let (hits, entries) = node.intersect(&self.local);
            if hits != 0 {
                let coming = |child: NodeRef| child.prefetch(view);
                self.next = O::enter(waiting, &mut self.waiting, hits, entries, &node.children, coming);
                return true;
            }
        } else {
            match self.next.leaf() {
                Leaf::Triangles(index) => view.triangles[index].intersect(&self.sheared, &mut self.search),
                Leaf::Mixed(index) => {
                    let mixed = &view.accel.mixed[index];
                    view.accel.intersect_mixed::<O>(mixed, &self.sheared, &mut self.search);
                }
            }
        }
        if O::ANY && self.search.found() {
            return false;
        }
        if self.search.best.t < best {
            self.local.shorten(&view.accel.space, self.search.best.t);
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
