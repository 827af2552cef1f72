//! Rays that take turns, so that none waits for memory.
//!
//! Where most of a tree lies in no near cache, half of a ray's time is waiting for the next node. Several
//! rays that take one step each, prefetching their next nodes in between, wait at the same time. Where the
//! tree is in a near cache that costs a quarter of a ray's time, since its state can no longer stay in
//! registers: so only [scattered](is_scattered) trees are walked in turns, and not by the rays of a camera,
//! which lie side by side and find what their neighbours have fetched.

use super::node::Node;
use super::stack::{Query, TraversalStack};
use super::traversal::{Arrays, Traversal};
use super::{Accel, Search};
use crate::math::Ray;
use crate::shape::Hit;

/// Number of rays that take turns.
const TURNS: usize = 6;

/// Number of nodes and leaves that a near cache holds: about two megabytes.
const NEAR: usize = 10_000;

/// Share of all visits to nodes and leaves that must go beyond the near cache for turns to pay: scenes below
/// 0.03 lost, above 0.1 gained.
const SCATTERED: f64 = 0.06;

/// Whether rays that come from everywhere would often visit what lies in no near cache, if that holds what
/// they visit most. A convex box is visited in proportion to its surface.
pub fn is_scattered(nodes: &[Node]) -> bool {
    let mut areas: Vec<f32> = nodes.iter().flat_map(Node::half_areas).collect();
    if areas.len() <= NEAR {
        return false;
    }
    let (near, last, far) = areas.select_nth_unstable_by(NEAR, |a, b| b.total_cmp(a));
    let sum = |areas: &[f32]| areas.iter().copied().map(f64::from).sum::<f64>();
    let far = sum(far) + f64::from(*last);
    far > SCATTERED * (sum(near) + far)
}

impl Accel {
    /// Whether these rays are better traced in turns.
    #[inline]
    pub(super) fn take_turns(&self, rays: &[Ray]) -> bool {
        self.scattered && rays.first().is_some_and(|ray| ray.from != Ray::FREE)
    }

    /// Continues searches begun elsewhere, reporting in any order; results are bitwise those of single
    /// traversal.
    pub(super) fn traverse_in_turns<O: Query>(
        &self,
        searches: &[Search],
        mut report: impl FnMut(usize, Option<Hit>),
    ) {
        let arrays = Arrays::new(self);
        let mut coming = searches.iter().enumerate();
        let mut begin = |report: &mut dyn FnMut(usize, Option<Hit>)| {
            coming.by_ref().find_map(|(number, search)| {
                let done = O::ANY && search.found();
                let walk = if done { None } else { Traversal::new(self, *search) };
                if walk.is_none() {
                    report(number, search.hit());
                }
                Some((number, walk?))
            })
        };
        let mut waiting: [TraversalStack<O>; TURNS] = std::array::from_fn(|_| TraversalStack::new());
        let mut walks: [Option<(usize, Traversal)>; TURNS] = std::array::from_fn(|_| begin(&mut report));
        let mut walking = walks.iter().flatten().count();
        while walking > 0 {
            for (slot, waiting) in walks.iter_mut().zip(&mut waiting) {
                let Some((number, walk)) = slot else { continue };
                if walk.step(&arrays, waiting) {
                    walk.prefetch(&arrays);
                } else {
                    report(*number, walk.search.hit());
                    waiting.clear();
                    *slot = begin(&mut report);
                    walking -= usize::from(slot.is_none());
                }
            }
        }
    }
}
