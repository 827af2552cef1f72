//! What waits while a ray looks at something else.

use super::node::NodeRef;
use crate::math::simd::F32x8;

/// Nodes that a ray has yet to look at. How many there are at hand is kept elsewhere, in a register.
pub trait Waiting {
    /// Any hit will do; else the closest is looked for.
    const ANY: bool;

    fn new() -> Self;

    /// Forgets what a ray has left behind that ended early.
    fn clear(&mut self);

    /// Answers with the first of the children that a ray enters (a bit each, at least one, and where) and lets
    /// the others wait. `coming` hears beforehand of those that are likely to be looked at.
    fn enter(
        &mut self,
        length: &mut usize,
        hits: u32,
        entries: F32x8,
        children: &[NodeRef; 8],
        coming: impl Fn(NodeRef),
    ) -> NodeRef;

    /// The next one, if any is left that is entered before `limit`.
    fn pop(&mut self, length: &mut usize, limit: f32) -> Option<NodeRef>;
}

#[cfg(test)]
mod tests {
    use super::super::pile::Pile;
    use super::super::stack::Stack;
    use super::*;

    fn entering<W: Waiting>(hits: u32, entries: &[f32; 8], limit: f32) -> Vec<NodeRef> {
        let children: [NodeRef; 8] = std::array::from_fn(NodeRef::node);
        let (mut waiting, mut length) = (W::new(), 0);
        let first = waiting.enter(&mut length, hits, F32x8::new(entries), &children, |_| {});
        std::iter::once(first).chain(std::iter::from_fn(|| waiting.pop(&mut length, limit))).collect()
    }

    #[test]
    fn the_closest_is_looked_for_by_distance_and_any_in_the_order_of_children() {
        let entries = [3.0f32, 1.0, 4.0, 1.5, 5.0, 9.0, 2.0, 6.0];
        for hits in 1..256u32 {
            let mut expected: Vec<usize> = (0..8).filter(|lane| hits >> lane & 1 == 1).collect();
            let nodes = |lanes: &[usize]| lanes.iter().map(|&lane| NodeRef::node(lane)).collect::<Vec<_>>();
            assert_eq!(entering::<Pile>(hits, &entries, 0.0), nodes(&expected));
            expected.sort_by(|&a, &b| entries[a].total_cmp(&entries[b]));
            for limit in [10.0, 4.0] {
                let first = expected[0];
                let near: Vec<usize> = expected
                    .iter()
                    .copied()
                    .filter(|&lane| lane == first || entries[lane] <= limit)
                    .collect();
                assert_eq!(entering::<Stack>(hits, &entries, limit), nodes(&near));
            }
        }
    }

    fn nothing_is_left_behind<W: Waiting>() {
        let (mut waiting, mut length) = (W::new(), 0);
        let children = std::array::from_fn(NodeRef::node);
        for _ in 0..100 {
            waiting.enter(&mut length, 0xff, F32x8::splat(0.0), &children, |_| {});
        }
        waiting.clear();
        assert_eq!(waiting.pop(&mut 0, 1.0), None);
    }

    fn last_in_is_first_out_however_many<W: Waiting>() {
        const MANY: usize = 200;
        let (mut waiting, mut length) = (W::new(), 0);
        let entries = F32x8::new(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        for i in 0..MANY {
            let child = std::array::from_fn(|lane| NodeRef::node(8 * i + lane));
            assert_eq!(waiting.enter(&mut length, 0b101, entries, &child, |_| {}), child[0]);
        }
        for i in (0..MANY).rev() {
            assert_eq!(waiting.pop(&mut length, 1.0), Some(NodeRef::node(8 * i + 2)));
        }
        assert_eq!(waiting.pop(&mut length, 1.0), None);
    }

    #[test]
    fn both_hold_any_number() {
        nothing_is_left_behind::<Stack>();
        nothing_is_left_behind::<Pile>();
        last_in_is_first_out_however_many::<Stack>();
        last_in_is_first_out_however_many::<Pile>();
    }
}
