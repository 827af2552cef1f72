//! The nodes that wait while a ray looks for the closest hit.

use super::node::NodeRef;
use super::waiting::Waiting;
use crate::math::simd::F32x8;

/// So many waiting nodes cost no memory from the heap: enough for all but pathological trees, few enough that
/// making the stack costs a ray nothing worth noting.
const FEW: usize = 64;

/// Nodes, each with the distance (in unit coordinates, never negative) where the ray enters it. Of a node's
/// children the nearest comes first.
pub struct Stack {
    few: [Entered; FEW],
    /// What waits below the few.
    more: Vec<Entered>,
}

/// The bits of the distance above those of the node: non-negative floats are ordered as their bits are.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Entered(u64);

impl Entered {
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

impl Waiting for Stack {
    const ANY: bool = false;

    #[inline(always)]
    fn new() -> Self {
        Self { few: [Entered(0); FEW], more: vec![] }
    }

    #[inline(always)]
    fn clear(&mut self) {
        self.more.clear();
    }

    /// All children are likely to be looked at.
    #[inline(always)]
    fn enter(
        &mut self,
        length: &mut usize,
        hits: u32,
        entries: F32x8,
        children: &[NodeRef; 8],
        coming: impl Fn(NodeRef),
    ) -> NodeRef {
        let entries = entries.to_array();
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
            coming(children[lane]);
            Entered::new(children[lane], entries[lane])
        };
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

    /// Those that are entered beyond `limit` are dropped.
    #[inline(always)]
    fn pop(&mut self, length: &mut usize, limit: f32) -> Option<NodeRef> {
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
