//! A ray's way through the tree.

use super::node::{Leaf, Node, NodeRef};
use super::space::LocalRay;
use super::triangles::{Sheared, Triangles};
use super::waiting::{Order, Waiting};
use super::{Accel, Search};

/// What a walk looks at.
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

/// A ray in the middle of the tree, without what waits: what is indexed cannot be held in registers, nor what
/// is in one structure with it.
pub struct Walk<'a> {
    pub search: Search<'a>,
    local: LocalRay,
    sheared: Sheared,
    next: NodeRef,
    /// How many nodes wait at hand.
    waiting: usize,
}

impl<'a> Walk<'a> {
    /// `None` where the ray passes by everything.
    #[inline(always)]
    pub fn new(accel: &Accel, search: Search<'a>) -> Option<Self> {
        let mut local = accel.space.enter(search.ray)?;
        local.shorten(&accel.space, search.best.t);
        let sheared = Sheared::new(search.ray, accel.near);
        Some(Self { search, local, sheared, next: NodeRef::ROOT, waiting: 0 })
    }

    /// Begins to bring what comes next into the cache.
    #[inline(always)]
    pub fn prefetch(&self, view: &View) {
        self.next.prefetch(view);
    }

    /// Looks at one node or leaf; false where there is no more to see.
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
