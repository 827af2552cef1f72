//! The order of a search for any hit.

use super::node::NodeRef;
use super::stack::{Query, TraversalStack};
use crate::math::simd::{F32x8, U32x8};

/// A node's children are visited in their order. Where a ray enters them does not matter, for it ends with
/// the first hit. So all children are pushed together, and their number is no branch for the processor to
/// predict.
pub struct AnyHit;

impl Query for AnyHit {
    const ANY: bool = true;
    type Kept = NodeRef;
    const NOTHING: NodeRef = NodeRef::EMPTY;

    #[inline(always)]
    fn enter(
        waiting: &mut TraversalStack<Self>,
        length: &mut usize,
        hits: u32,
        _entries: F32x8,
        children: &[NodeRef; 8],
        _coming: impl Fn(NodeRef),
    ) -> NodeRef {
        waiting.make_room(length);
        let others = hits & (hits - 1);
        let put = U32x8::new(*bytemuck::cast_ref(children)).backwards(others as u8).to_array();
        waiting.few[*length..*length + 8].copy_from_slice(bytemuck::cast_ref::<_, [NodeRef; 8]>(&put));
        *length += others.count_ones() as usize;
        children[hits.trailing_zeros() as usize & 7]
    }

    #[inline(always)]
    fn node(kept: NodeRef, _limit: f32) -> Option<NodeRef> {
        Some(kept)
    }
}
