//! What waits while a ray looks at something else.

use super::node::NodeRef;
use crate::math::simd::F32x8;

/// So many waiting nodes cost no memory from the heap: enough for all but pathological trees, few enough that
/// making room for them costs a ray nothing worth noting.
pub const FEW: usize = 64;

/// What a ray looks for, and so in which order it looks at nodes.
pub trait Order: Sized {
    /// Any hit will do; else the closest is looked for.
    const ANY: bool;

    /// What is kept of a node that waits.
    type Kept: Copy;
    /// It stands where nothing waits.
    const NOTHING: Self::Kept;

    /// Answers with the first of the children that a ray enters (a bit each, at least one, and where) and lets
    /// the others wait. `coming` hears beforehand of those that are likely to be looked at.
    fn enter(
        waiting: &mut Waiting<Self>,
        length: &mut usize,
        hits: u32,
        entries: F32x8,
        children: &[NodeRef; 8],
        coming: impl Fn(NodeRef),
    ) -> NodeRef;

    /// The node, if it is worth a look for a ray that ends at `limit`.
    fn node(kept: Self::Kept, limit: f32) -> Option<NodeRef>;
}

/// Nodes that a ray has yet to look at, the last first. How many there are at hand is kept elsewhere, in a
/// register.
pub struct Waiting<O: Order> {
    pub few: [O::Kept; FEW],
    /// What waits below the few.
    more: Vec<O::Kept>,
}

impl<O: Order> Waiting<O> {
    #[inline(always)]
    pub fn new() -> Self {
        Self { few: [O::NOTHING; FEW], more: vec![] }
    }

    /// Forgets what a ray has left behind that ended early.
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

    /// The last node that is worth a look for a ray that ends at `limit`; those after it are dropped.
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

    fn entering<O: Order>(hits: u32, entries: &[f32; 8], limit: f32) -> Vec<NodeRef> {
        let children: [NodeRef; 8] = std::array::from_fn(NodeRef::node);
        let (mut waiting, mut length) = (Waiting::<O>::new(), 0);
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

    fn nothing_is_left_behind<O: Order>() {
        let (mut waiting, mut length) = (Waiting::<O>::new(), 0);
        let children = std::array::from_fn(NodeRef::node);
        for _ in 0..100 {
            O::enter(&mut waiting, &mut length, 0xff, F32x8::splat(0.0), &children, |_| {});
        }
        waiting.clear();
        assert_eq!(waiting.pop(&mut 0, 1.0), None);
    }

    fn last_in_is_first_out_however_many<O: Order>() {
        const MANY: usize = 200;
        let (mut waiting, mut length) = (Waiting::<O>::new(), 0);
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
