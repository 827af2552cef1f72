//! The nodes that wait while a ray looks at others.

use super::node::NodeRef;

/// So many waiting nodes cost no memory from the heap: enough for all but pathological trees, few enough that making
/// the stack costs a ray nothing worth noting.
const FEW: usize = 64;

/// Nodes, each with the distance (in unit coordinates) where the ray enters it.
pub struct Stack {
    few: [(NodeRef, f32); FEW],
    length: usize,
    more: Vec<(NodeRef, f32)>,
}

impl Stack {
    #[inline(always)]
    pub fn new() -> Self {
        Self { few: [(NodeRef::EMPTY, 0.0); FEW], length: 0, more: vec![] }
    }

    #[inline(always)]
    pub fn push(&mut self, node: NodeRef, entry: f32) {
        match self.few.get_mut(self.length) {
            Some(place) => *place = (node, entry),
            None => self.more.push((node, entry)),
        }
        self.length += 1;
    }

    /// The last node that is entered before `limit`; those after it are dropped.
    #[inline(always)]
    pub fn pop(&mut self, limit: f32) -> Option<NodeRef> {
        while self.length > 0 {
            self.length -= 1;
            let place = self.few.get(self.length).copied();
            let (node, entry) = place.or_else(|| self.more.pop())?;
            if entry <= limit {
                return Some(node);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_in_is_first_out_however_many() {
        let mut stack = Stack::new();
        for i in 0..3 * FEW {
            stack.push(NodeRef::node(i), (i % 2) as f32);
        }
        for i in (0..3 * FEW).rev() {
            // The odd ones lie too far.
            if i % 2 == 0 {
                assert_eq!(stack.pop(0.5), Some(NodeRef::node(i)));
            }
        }
        assert_eq!(stack.pop(0.5), None);
    }
}
