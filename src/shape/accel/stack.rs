//! The stack of nodes that a ray has yet to visit.

use super::node::NodeRef;
use crate::math::simd::F32x8;

/// Most waiting nodes that take no memory from the heap: enough for all but pathological trees, few enough
/// that making room for them costs a ray next to nothing.
pub const FEW: usize = 64;

/// What a ray searches for, and so in which order it visits nodes.
pub trait Query: Sized {
    /// Whether any hit will do; else the closest is searched for.
    const ANY: bool;

    /// What the stack holds of a node.
    type Kept: Copy;
    /// The initial value of places in the stack.
    const NOTHING: Self::Kept;

    /// Returns the first of the children that a ray enters (`hits` has a bit for each, at least one,
    /// `entries` where) and pushes the others. `coming` is called beforehand with those that are likely to be
    /// visited.
    fn enter(
        waiting: &mut TraversalStack<Self>,
        length: &mut usize,
        hits: u32,
        entries: F32x8,
        children: &[NodeRef; 8],
        coming: impl Fn(NodeRef),
    ) -> NodeRef;

    /// The node, if a ray that ends at `limit` must visit it.
    fn node(kept: Self::Kept, limit: f32) -> Option<NodeRef>;
}

/// Nodes that a ray has yet to visit, the last first. The number of those in `few` is kept elsewhere, in a
/// register.
pub struct TraversalStack<O: Query> {
    pub few: [O::Kept; FEW],
    /// The part of the stack below `few`.
    more: Vec<O::Kept>,
}

impl<O: Query> TraversalStack<O> {
    #[inline(always)]
    pub fn new() -> Self {
        Self { few: [O::NOTHING; FEW], more: vec![] }
    }

    /// Drops what a ray that ended early has left.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.more.clear();
    }

    /// Makes room for all children of a node.
    #[inline(always)]
    pub fn make_room(&mut self, length: &mut usize) {
        if *length + 8 > FEW {
            self.more.extend(&self.few[..*length]);
            *length = 0;
        }
    }

    /// Pops the last node that a ray that ends at `limit` must visit; those after it are dropped.
    #[inline(always)]
    pub fn pop(&mut self, length: &mut usize, limit: f32) -> Option<NodeRef> {
        loop {
            while *length > 0 {
                *length -= 1;
                if let Some(node) = O::node(self.few[*length & (FEW - 1)], limit) {
                    return Some(node);
                }
            }
            let below = self.more.len().checked_sub(1)? / (FEW / 2) * (FEW / 2);
            *length = self.more.len() - below;
            self.few[..*length].copy_from_slice(&self.more[below..]);
            self.more.truncate(below);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::any_hit::AnyHit;
    use super::super::closest_hit::ClosestHit;
    use super::*;

    fn entering<O: Query>(hits: u32, entries: &[f32; 8], limit: f32) -> Vec<NodeRef> {
        let children: [NodeRef; 8] = std::array::from_fn(NodeRef::node);
        let (mut waiting, mut length) = (TraversalStack::<O>::new(), 0);
        let first = O::enter(&mut waiting, &mut length, hits, F32x8::new(entries), &children, |_| {});
        std::iter::once(first).chain(std::iter::from_fn(|| waiting.pop(&mut length, limit))).collect()
    }

    #[test]
    fn the_closest_is_looked_for_by_distance_and_any_in_the_order_of_children() {
        let entries = [3.0f32, 1.0, 4.0, 1.5, 5.0, 9.0, 2.0, 6.0];
        for hits in 1..256u32 {
            let mut expected: Vec<usize> = (0..8).filter(|lane| hits >> lane & 1 == 1).collect();
            let nodes = |lanes: &[usize]| lanes.iter().map(|&lane| NodeRef::node(lane)).collect::<Vec<_>>();
            assert_eq!(entering::<AnyHit>(hits, &entries, 0.0), nodes(&expected));
            expected.sort_by(|&a, &b| entries[a].total_cmp(&entries[b]));
            for limit in [10.0, 4.0] {
                let first = expected[0];
                let near: Vec<usize> = expected
                    .iter()
                    .copied()
                    .filter(|&lane| lane == first || entries[lane] <= limit)
                    .collect();
                assert_eq!(entering::<ClosestHit>(hits, &entries, limit), nodes(&near));
            }
        }
    }

    fn nothing_is_left_behind<O: Query>() {
        let (mut waiting, mut length) = (TraversalStack::<O>::new(), 0);
        let children = std::array::from_fn(NodeRef::node);
        for _ in 0..100 {
            O::enter(&mut waiting, &mut length, 0xff, F32x8::splat(0.0), &children, |_| {});
        }
        waiting.clear();
        assert_eq!(waiting.pop(&mut 0, 1.0), None);
    }

    fn last_in_is_first_out_however_many<O: Query>() {
        const MANY: usize = 200;
        let (mut waiting, mut length) = (TraversalStack::<O>::new(), 0);
        let entries = F32x8::new(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        for i in 0..MANY {
            let child = std::array::from_fn(|lane| NodeRef::node(8 * i + lane));
            assert_eq!(O::enter(&mut waiting, &mut length, 0b101, entries, &child, |_| {}), child[0]);
        }
        for i in (0..MANY).rev() {
            assert_eq!(waiting.pop(&mut length, 1.0), Some(NodeRef::node(8 * i + 2)));
        }
        assert_eq!(waiting.pop(&mut length, 1.0), None);
    }

    #[test]
    fn both_hold_any_number() {
        nothing_is_left_behind::<ClosestHit>();
        nothing_is_left_behind::<AnyHit>();
        last_in_is_first_out_however_many::<ClosestHit>();
        last_in_is_first_out_however_many::<AnyHit>();
    }
}
