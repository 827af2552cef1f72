//! The nodes that wait while a ray looks at others.

use super::node::NodeRef;

/// So many waiting nodes cost no memory from the heap: enough for all but pathological trees, few enough that
/// making the stack costs a ray nothing worth noting.
const FEW: usize = 64;

/// Nodes, each with the distance (in unit coordinates, never negative) where the ray enters it. How many
/// there are is kept elsewhere, in a register.
pub struct Stack {
    few: [Waiting; FEW],
    /// What waits below the few.
    more: Vec<Waiting>,
}

/// The bits of the distance above those of the node: non-negative floats are ordered as their bits are.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(node: NodeRef, entry: f32) -> Self {
        Self(u64::from(entry.to_bits()) << 32 | u64::from(node.bits()))
    }

    #[inline(always)]
    fn node(self) -> NodeRef {
        NodeRef::from_bits(self.0 as u32)
    }

    #[inline(always)]
    fn entry(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
}

impl Stack {
    #[inline(always)]
    pub fn new() -> Self {
        Self { few: [Waiting(0); FEW], more: vec![] }
    }

    /// Forgets what a ray has left behind that ended early.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.more.clear();
    }

    /// Answers with the first of the children that a ray enters (a bit each, at least one) and lets the
    /// others wait. Any hit will do (`ANY`) in the order of the children, the closest one is best looked for
    /// in the order of distances: then all are likely to be looked at, and `coming` hears of them beforehand.
    #[inline(always)]
    pub fn enter<const ANY: bool>(
        &mut self,
        length: &mut usize,
        hits: u32,
        entries: &[f32; 8],
        children: &[NodeRef; 8],
        coming: impl Fn(NodeRef),
    ) -> NodeRef {
        let first = hits.trailing_zeros() as usize & 7;
        let mut rest = hits & (hits - 1);
        if rest == 0 {
            return children[first];
        }
        if *length + 8 > FEW {
            self.more.extend(&self.few[..*length]);
            *length = 0;
        }
        let waiting = |lane: usize| {
            if !ANY {
                coming(children[lane]);
            }
            Waiting::new(children[lane], entries[lane])
        };
        if ANY {
            let mut lanes = hits;
            while lanes & (lanes - 1) != 0 {
                let lane = 31 - lanes.leading_zeros();
                lanes ^= 1 << lane;
                self.few[*length] = waiting(lane as usize & 7);
                *length += 1;
            }
            return children[first];
        }
        let mut nearest = waiting(first);
        let second = waiting(rest.trailing_zeros() as usize & 7);
        rest &= rest - 1;
        let farther = if nearest < second { second } else { nearest };
        nearest = if nearest < second { nearest } else { second };
        self.few[*length] = farther;
        let bottom = *length;
        *length += 1;
        while rest != 0 {
            let next = waiting(rest.trailing_zeros() as usize & 7);
            rest &= rest - 1;
            let farther = if nearest < next { next } else { nearest };
            nearest = if nearest < next { nearest } else { next };
            let mut at = *length;
            while at > bottom && self.few[at - 1] < farther {
                self.few[at] = self.few[at - 1];
                at -= 1;
            }
            self.few[at] = farther;
            *length += 1;
        }
        nearest.node()
    }

    /// The last node that is entered before `limit`; those after it are dropped.
    #[inline(always)]
    pub fn pop(&mut self, length: &mut usize, limit: f32) -> Option<NodeRef> {
        loop {
            while *length > 0 {
                *length -= 1;
                let waiting = self.few[*length & (FEW - 1)];
                if waiting.entry() <= limit {
                    return Some(waiting.node());
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
    use super::*;

    #[test]
    fn the_nearest_child_is_first_and_the_others_follow() {
        let children: [NodeRef; 8] = std::array::from_fn(NodeRef::node);
        let entries = [3.0f32, 1.0, 4.0, 1.5, 5.0, 9.0, 2.0, 6.0];
        for hits in 1..256u32 {
            let mut expected: Vec<usize> = (0..8).filter(|lane| hits >> lane & 1 == 1).collect();
            let (mut any, mut length) = (Stack::new(), 0);
            let mut order = vec![any.enter::<true>(&mut length, hits, &entries, &children, |_| {})];
            order.extend(std::iter::from_fn(|| any.pop(&mut length, 10.0)));
            assert_eq!(order, expected.iter().map(|&lane| NodeRef::node(lane)).collect::<Vec<_>>());
            expected.sort_by(|&a, &b| entries[a].total_cmp(&entries[b]));
            for limit in [10.0, 4.0] {
                let (mut closest, mut length) = (Stack::new(), 0);
                let mut order = vec![closest.enter::<false>(&mut length, hits, &entries, &children, |_| {})];
                order.extend(std::iter::from_fn(|| closest.pop(&mut length, limit)));
                let near =
                    expected.iter().enumerate().filter(|(i, lane)| *i == 0 || entries[**lane] <= limit);
                assert_eq!(order, near.map(|(_, &lane)| NodeRef::node(lane)).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn nothing_is_left_behind() {
        let (mut stack, mut length) = (Stack::new(), 0);
        let children = std::array::from_fn(NodeRef::node);
        for _ in 0..FEW {
            stack.enter::<true>(&mut length, 0xff, &[0.0; 8], &children, |_| {});
        }
        stack.clear();
        assert_eq!(stack.pop(&mut 0, 1.0), None);
    }

    #[test]
    fn last_in_is_first_out_however_many() {
        let (mut stack, mut length) = (Stack::new(), 0);
        for i in 0..3 * FEW {
            let child = std::array::from_fn(|lane| NodeRef::node(8 * i + lane));
            assert_eq!(
                stack.enter::<false>(
                    &mut length,
                    0b101,
                    &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                    &child,
                    |_| {}
                ),
                child[0]
            );
        }
        for i in (0..3 * FEW).rev() {
            assert_eq!(stack.pop(&mut length, 1.0), Some(NodeRef::node(8 * i + 2)));
        }
        assert_eq!(stack.pop(&mut length, 1.0), None);
    }
}
