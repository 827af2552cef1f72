//! The nodes that wait while a ray looks for anything at all.

use super::node::NodeRef;
use super::waiting::Waiting;
use crate::math::simd::{F32x8, U32x8};

/// So many waiting nodes cost no memory from the heap.
const FEW: usize = 64;

/// Nodes in the order in which they are looked at: of a node's children the first comes first. Where a ray
/// enters them does not matter, for it ends with the first hit. So all children are put down together, and how
/// many there are is no branch for the processor to guess.
pub struct Pile {
    few: [NodeRef; FEW],
    /// What waits below the few.
    more: Vec<NodeRef>,
}

impl Waiting for Pile {
    const ANY: bool = true;

    #[inline(always)]
    fn new() -> Self {
        Self { few: [NodeRef::EMPTY; FEW], more: vec![] }
    }

    #[inline(always)]
    fn clear(&mut self) {
        self.more.clear();
    }

    #[inline(always)]
    fn enter(
        &mut self,
        length: &mut usize,
        hits: u32,
        _entries: F32x8,
        children: &[NodeRef; 8],
        _coming: impl Fn(NodeRef),
    ) -> NodeRef {
        if *length + 8 > FEW {
            self.more.extend(&self.few[..*length]);
            *length = 0;
        }
        let others = hits & (hits - 1);
        let put = U32x8::new(*bytemuck::cast_ref(children)).backwards(others as u8).to_array();
        self.few[*length..*length + 8].copy_from_slice(bytemuck::cast_ref::<_, [NodeRef; 8]>(&put));
        *length += others.count_ones() as usize;
        children[hits.trailing_zeros() as usize & 7]
    }

    #[inline(always)]
    fn pop(&mut self, length: &mut usize, _limit: f32) -> Option<NodeRef> {
        if *length == 0 {
            let below = self.more.len().checked_sub(1)? / (FEW / 2) * (FEW / 2);
            *length = self.more.len() - below;
            self.few[..*length].copy_from_slice(&self.more[below..]);
            self.more.truncate(below);
        }
        *length -= 1;
        Some(self.few[*length & (FEW - 1)])
    }
}
