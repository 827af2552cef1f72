//! From a binary tree to one with eight children a node.
//!
//! Among all trees that keep the binary tree's order, the one of least expected cost is found from the leaves
//! up (Ylitie, Karras & Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs", section 3.1): for each binary node and each count i, the least cost of at most i trees that
//! together hold what is below it. A ray enters a box with a chance proportional to its area.

use bytemuck::{Pod, Zeroable};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use std::sync::atomic::{AtomicU32, Ordering};

/// Cost of testing a block of four primitives of a kind, in tests of a node.
const BLOCK_COST: f32 = 0.6;

/// What could be one leaf is divided only if that leaves no more than this fraction of its cost: full blocks
/// save memory, which large scenes wait for.
const THRIFT: f32 = 0.6;

/// Most items of a leaf.
pub const LEAF: u16 = 4;

/// Fewest nodes of a tree that is folded by several threads.
const MANY: usize = 1 << 14;

/// The level down to which their ways part.
const LEVELS: u32 = 10;

/// What a leaf of the binary tree holds. Small numbers are as wide as leaves no padding.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Content {
    /// Area of the surface, in unit coordinates.
    pub surface: f32,
    /// Number of items of a leaf that it takes up.
    pub size: u16,
    /// One of the bits of [`kind`].
    pub kind: u16,
}

/// Bits of kinds that are in blocks of their own.
pub mod kind {
    pub const TRIANGLE: u16 = 1;
    pub const PATCH: u16 = 2;
    pub const CUBE: u16 = 4;
    pub const SPHERE: u16 = 8;
    pub const CYLINDER: u16 = 16;
    pub const INSTANCE: u16 = 32;
}

/// How a node of the binary tree and what is below it are best folded.
#[derive(Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Decision {
    /// The least cost of one tree.
    cost: f32,
    surface: f32,
    /// The choices that lead to the least costs: `choices[i]` trees of at most i come from the left child,
    /// and 0 means as for i − 1. `choices[1]` is 0 for a leaf, and `choices[0]` is how many of a node's eight
    /// children come from the left.
    pub choices: [u8; 8],
    /// Number of items below the node; more than [`LEAF`] are too many for a leaf.
    size: u16,
    kinds: u16,
}

impl Decision {
    /// Cost of testing all items below the node, if they are one leaf.
    fn leaf_cost(&self) -> f32 {
        BLOCK_COST * self.kinds.count_ones() as f32
    }

    pub fn is_leaf(&self) -> bool {
        self.choices[1] == 0
    }

    pub fn has_triangles(&self) -> bool {
        self.kinds & kind::TRIANGLE != 0
    }

    pub fn only_triangles(&self) -> bool {
        self.kinds == kind::TRIANGLE
    }

    /// How promising a shadow ray's search below the node is: surface over the cost of searching it.
    pub fn promise(&self) -> f32 {
        self.surface / self.cost
    }
}

/// The decisions of all nodes. Each is written once, by the thread that is at the node; the words are atomic only so
/// that all threads may write to one list.
struct Decisions(Vec<[AtomicU32; WORDS]>);

const WORDS: usize = size_of::<Decision>() / size_of::<AtomicU32>();

impl Decisions {
    fn get(&self, index: usize) -> Decision {
        bytemuck::cast(self.0[index].each_ref().map(|word| word.load(Ordering::Relaxed)))
    }

    fn keep(&self, index: usize, decided: Decided) -> Decided {
        let words: [u32; WORDS] = bytemuck::cast(decided.0);
        self.0[index].iter().zip(words).for_each(|(to, word)| to.store(word, Ordering::Relaxed));
        decided
    }
}

/// A decision, and the least costs of at most 1, 2, … 7 trees: known only while decisions are made.
type Decided = (Decision, [f32; 7]);

/// How a binary tree is folded into nodes of eight.
pub struct Plan<'a> {
    pub binary: &'a Bvh2,
    decisions: Decisions,
}

impl<'a> Plan<'a> {
    /// Plans the tree; `contents` tells what each primitive is.
    pub fn new(binary: &'a Bvh2, contents: &[Content]) -> Self {
        let plan = Self { binary, decisions: Decisions(bytemuck::zeroed_vec(binary.nodes.len())) };
        plan.decide(0, contents, if plan.is_large() { LEVELS } else { 0 });
        plan
    }

    /// Whether several threads are worth their trouble.
    pub fn is_large(&self) -> bool {
        self.binary.nodes.len() > MANY
    }

    /// Decides on a node and all below it, down to `levels` below by several threads.
    fn decide(&self, index: usize, contents: &[Content], levels: u32) -> Decided {
        let node = &self.binary.nodes[index];
        if levels == 0 || node.is_leaf() {
            return self.decide_subtree(index, contents);
        }
        let left = node.first_index as usize;
        let (left, right) = rayon::join(
            || self.decide(left, contents, levels - 1),
            || self.decide(left + 1, contents, levels - 1),
        );
        self.decisions.keep(index, decide_fork(node, &left, &right))
    }

    /// The same by one thread. There is no telling how deep the subtree is, so nothing calls itself here.
    fn decide_subtree(&self, root: usize, contents: &[Content]) -> Decided {
        // Of trees whose sibling is not decided yet.
        let mut known: Vec<Decided> = vec![];
        let mut waiting = vec![(root, false)];
        while let Some((index, are_children_decided)) = waiting.pop() {
            let node = &self.binary.nodes[index];
            let decided = if node.is_leaf() {
                self.decide_leaf(node, contents)
            } else if are_children_decided {
                let [left, right] = [2, 1].map(|from_end| known[known.len() - from_end]);
                known.truncate(known.len() - 2);
                decide_fork(node, &left, &right)
            } else {
                let left = node.first_index as usize;
                waiting.extend([(index, true), (left + 1, false), (left, false)]);
                continue;
            };
            known.push(self.decisions.keep(index, decided));
        }
        known[0]
    }

    pub fn decision(&self, index: u32) -> Decision {
        self.decisions.get(index as usize)
    }

    fn decide_leaf(&self, node: &Bvh2Node, contents: &[Content]) -> Decided {
        let mut decision = Decision::default();
        for &primitive in self.of_leaf(node) {
            let Content { surface, size, kind } = contents[primitive as usize];
            decision.surface += surface;
            decision.size += size;
            decision.kinds |= kind;
        }
        decision.cost = node.aabb().half_area() * decision.leaf_cost();
        (decision, [decision.cost; 7])
    }

    /// The primitives of a leaf of the binary tree.
    fn of_leaf(&self, node: &Bvh2Node) -> &[u32] {
        let first = node.first_index as usize;
        &self.binary.primitive_indices[first..first + node.prim_count as usize]
    }

    /// The primitives below a binary node that becomes a leaf.
    pub fn primitives(&self, index: u32) -> impl Iterator<Item = u32> {
        let mut waiting = [index; LEAF as usize];
        let mut count = 1;
        std::iter::from_fn(move || {
            while count > 0 {
                count -= 1;
                let node = &self.binary.nodes[waiting[count] as usize];
                if node.is_leaf() {
                    return Some(self.of_leaf(node));
                }
                waiting[count] = node.first_index + 1;
                waiting[count + 1] = node.first_index;
                count += 2;
            }
            None
        })
        .flatten()
        .copied()
    }
}

/// For a node with children, whose least costs are known.
fn decide_fork(node: &Bvh2Node, (l, of_left): &Decided, (r, of_right): &Decided) -> Decided {
    let area = node.aabb().half_area();
    let mut decision = Decision {
        surface: l.surface + r.surface,
        size: (l.size + r.size).min(LEAF + 1),
        kinds: l.kinds | r.kinds,
        ..Decision::default()
    };
    let split = |trees: usize| {
        let mut best = (f32::INFINITY, 0);
        for k in trees.saturating_sub(7).max(1)..=(trees - 1).min(7) {
            let cost = of_left[k - 1] + of_right[trees - k - 1];
            if cost < best.0 {
                best = (cost, k as u8);
            }
        }
        best
    };
    let (inner, from_left) = split(8);
    let (inner, leaf) = (inner + area, area * decision.leaf_cost());
    decision.choices[0] = from_left;
    decision.choices[1] = u8::from(decision.size > LEAF || inner < leaf);
    let mut best = if decision.choices[1] == 0 { leaf } else { inner };
    let mut costs = [best; 7];
    decision.cost = best;
    for trees in 2..8 {
        let (cost, from_left) = split(trees);
        let thrift = if decision.size <= LEAF && decision.choices[1] == 0 { THRIFT } else { 1.0 };
        if cost < best * thrift {
            (best, decision.choices[trees]) = (cost, from_left);
        }
        costs[trees - 1] = best;
    }
    (decision, costs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::Pages;
    use crate::shape::accel::binned_sah::grow;
    use glam::Vec3A;
    use obvhs::aabb::Aabb;
    use rand_pcg::{Pcg32, rand_core::Rng};

    #[test]
    fn several_threads_decide_as_one() {
        let mut rng = Pcg32::new(0, 1);
        let mut uniform = || rng.next_u32() as f32 / 4294967296.0;
        let mut corner = || Vec3A::new(uniform(), uniform(), uniform());
        let mut boxes = Pages::zeroed(50_000);
        boxes.fill_with(|| {
            let at = corner();
            Aabb::new(at, at + 0.01 * corner())
        });
        let kinds = [kind::TRIANGLE, kind::PATCH, kind::SPHERE];
        let content = |i: usize| Content { surface: i as f32, size: 1, kind: kinds[i % 7 % 3] };
        let contents: Vec<Content> = (0..boxes.len()).map(content).collect();
        let binary = grow(boxes, (0..contents.len() as u32).collect(), usize::from(LEAF));
        let plan = Plan::new(&binary, &contents);
        assert!(plan.is_large());
        let words = |plan: &Plan| -> Vec<u32> {
            plan.decisions.0.iter().flatten().map(|word| word.load(Ordering::Relaxed)).collect()
        };
        let by_several = words(&plan);
        plan.decisions.0.iter().flatten().for_each(|word| word.store(0, Ordering::Relaxed));
        plan.decide(0, &contents, 0);
        assert!(by_several == words(&plan));
    }
}
