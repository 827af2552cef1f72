//! The order of a search for the closest hit.

use super::node::NodeRef;
use super::stack::{Query, TraversalStack};
use crate::math::simd::F32x8;

/// A node's nearest child is visited first: nodes wait with the distance (in unit coordinates, never
/// negative) where the ray enters them, and those beyond its end are dropped.
pub struct ClosestHit;

/// The bits of the distance above those of the node: non-negative floats are ordered as their bits are.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub struct Entered(u64);

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

impl Query for ClosestHit {
    const ANY: bool = false;
    type Kept = Entered;
    const NOTHING: Entered = Entered(0);

    /// All children are likely to be visited.
    #[inline(always)]
    fn enter(
        waiting: &mut TraversalStack<Self>,
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
        waiting.make_room(length);
        let entered = |lane: usize| {
            coming(children[lane]);
            Entered::new(children[lane], entries[lane])
        };
        let mut nearest = entered(first);
        let second = entered(rest.trailing_zeros() as usize & 7);
        rest &= rest - 1;
        let farther = if nearest < second { second } else { nearest };
        nearest = if nearest < second { nearest } else { second };
        waiting.few[*length] = farther;
        let bottom = *length;
        *length += 1;
        while rest != 0 {
            let next = entered(rest.trailing_zeros() as usize & 7);
            rest &= rest - 1;
            let farther = if nearest < next { next } else { nearest };
            nearest = if nearest < next { nearest } else { next };
            let mut at = *length;
            while at > bottom && waiting.few[at - 1] < farther {
                waiting.few[at] = waiting.few[at - 1];
                at -= 1;
            }
            waiting.few[at] = farther;
            *length += 1;
        }
        nearest.node()
    }

    #[inline(always)]
    fn node(kept: Entered, limit: f32) -> Option<NodeRef> {
        (kept.entry() <= limit).then(|| kept.node())
    }
}
