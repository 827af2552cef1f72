//! From a binary tree to one with eight children a node.
//!
//! Among all trees that keep the binary tree's order, the one of least expected cost is found from the leaves
//! up (Ylitie, Karras & Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs", section 3.1): for each binary node and each count i, the least cost of at most i trees that
//! together hold what is below it. A ray enters a box with a chance proportional to its area.

use super::node::{Node, NodeRef};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

/// Cost of testing a block of four primitives of a kind, in tests of a node.
const BLOCK_COST: f32 = 0.6;

/// What could be one leaf is divided only if that leaves no more than this fraction of its cost: full blocks
/// save memory, which large scenes wait for.
const THRIFT: f32 = 0.6;

/// Most items of a leaf.
pub const LEAF: u8 = 4;

/// What a leaf of the binary tree holds.
#[derive(Clone, Copy)]
pub struct Content {
    /// Area of the surface, in unit coordinates.
    pub surface: f32,
    /// Number of items of a leaf that it takes up.
    pub size: u8,
    /// One of the bits of [`kind`].
    pub kind: u8,
}

/// Bits of kinds that are in blocks of their own.
pub mod kind {
    pub const TRIANGLE: u8 = 1;
    pub const PATCH: u8 = 2;
    pub const CUBE: u8 = 4;
    pub const SPHERE: u8 = 8;
    pub const CYLINDER: u8 = 16;
    pub const INSTANCE: u8 = 32;
}

/// How a node of the binary tree and what is below it are best folded.
#[derive(Clone, Copy, Default)]
struct Decision {
    /// The least cost of one tree.
    cost: f32,
    /// The choices that lead to the least costs: `choices[i]` trees of at most i come from the left child,
    /// and 0 means as for i − 1. `choices[1]` is 0 for a leaf, and `choices[0]` is how many of a node's eight
    /// children come from the left.
    choices: [u8; 8],
    surface: f32,
    /// Number of items below the node; more than [`LEAF`] are too many for a leaf.
    size: u8,
    kinds: u8,
}

impl Decision {
    /// Cost of testing all items below the node, if they are one leaf.
    fn leaf_cost(&self) -> f32 {
        BLOCK_COST * self.kinds.count_ones() as f32
    }
}

/// The least costs of at most 1, 2, … 7 trees: known only while decisions are made.
type Costs = [f32; 7];

/// How a binary tree is folded into nodes of eight.
pub struct Plan<'a> {
    binary: &'a Bvh2,
    decisions: Vec<Decision>,
}

/// A node of eight that is planned.
#[derive(Default)]
pub struct Wide {
    /// Binary nodes that become its children, the most promising for a shadow ray first.
    children: [u32; 8],
    count: u8,
    /// A bit for each child that is a leaf.
    leaves: u8,
    /// The index of the first child that is a node.
    first_node: u32,
    /// The index of the first child that is a leaf.
    first_leaf: u32,
}

impl<'a> Plan<'a> {
    /// Plans the tree; `contents` tells what each primitive is.
    pub fn new(binary: &'a Bvh2, contents: &[Content]) -> Self {
        let mut plan = Self { binary, decisions: vec![Decision::default(); binary.nodes.len()] };
        // Of trees whose sibling is not decided yet.
        let mut known: Vec<Costs> = vec![];
        let mut waiting = vec![(0, false)];
        while let Some((index, are_children_decided)) = waiting.pop() {
            let node = &binary.nodes[index];
            let (decision, costs) = if node.is_leaf() {
                plan.decide_leaf(node, contents)
            } else if are_children_decided {
                let [left, right] = [2, 1].map(|from_end| known[known.len() - from_end]);
                known.truncate(known.len() - 2);
                plan.decide_fork(node, &left, &right)
            } else {
                let left = node.first_index as usize;
                waiting.extend([(index, true), (left + 1, false), (left, false)]);
                continue;
            };
            plan.decisions[index] = decision;
            known.push(costs);
        }
        plan
    }

    fn decide_leaf(&self, node: &Bvh2Node, contents: &[Content]) -> (Decision, Costs) {
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

    /// For a node with children, whose least costs are known.
    fn decide_fork(&self, node: &Bvh2Node, of_left: &Costs, of_right: &Costs) -> (Decision, Costs) {
        let area = node.aabb().half_area();
        let (left, right) = (node.first_index as usize, node.first_index as usize + 1);
        let (l, r) = (&self.decisions[left], &self.decisions[right]);
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

    pub fn has_triangles(&self, index: u32) -> bool {
        self.decisions[index as usize].kinds & kind::TRIANGLE != 0
    }

    pub fn only_triangles(&self, index: u32) -> bool {
        self.decisions[index as usize].kinds == kind::TRIANGLE
    }

    /// All nodes, the children of each next to each other, and the binary nodes that become leaves.
    pub fn lay_out(&self) -> (Vec<Wide>, Vec<u32>) {
        let mut nodes = vec![Wide::default()];
        let mut leaves = vec![];
        let mut waiting = vec![(0, 0)];
        while let Some((index, to)) = waiting.pop() {
            let mut wide =
                Wide { first_node: nodes.len() as u32, first_leaf: leaves.len() as u32, ..Wide::default() };
            self.children(index, &mut wide);
            for (slot, &child) in wide.children[..usize::from(wide.count)].iter().enumerate() {
                if self.decisions[child as usize].choices[1] == 0 {
                    wide.leaves |= 1 << slot;
                    leaves.push(child);
                } else {
                    waiting.push((child, nodes.len()));
                    nodes.push(Wide::default());
                }
            }
            nodes[to] = wide;
        }
        (nodes, leaves)
    }

    /// The finished node, given where all leaves are.
    pub fn node(&self, wide: &Wide, leaves: &[NodeRef]) -> Node {
        let mut node = Node::empty();
        let (mut next_node, mut next_leaf) = (wide.first_node as usize, wide.first_leaf as usize);
        for (slot, &child) in wide.children[..usize::from(wide.count)].iter().enumerate() {
            let target = if wide.leaves >> slot & 1 == 1 {
                next_leaf += 1;
                leaves[next_leaf - 1]
            } else {
                next_node += 1;
                NodeRef::node(next_node - 1)
            };
            let aabb = self.binary.nodes[child as usize].aabb();
            node.set(slot, aabb.min.to_array(), aabb.max.to_array(), target);
        }
        node
    }

    /// Finds the children of the node made of binary node `index`.
    fn children(&self, index: u32, wide: &mut Wide) {
        let node = &self.binary.nodes[index as usize];
        if node.is_leaf() {
            self.collect(index, 1, wide);
        } else {
            let from_left = self.decisions[index as usize].choices[0];
            self.collect(node.first_index, from_left, wide);
            self.collect(node.first_index + 1, 8 - from_left, wide);
        }
        // Surface of a child over the cost of searching it.
        let promise = |child: u32| {
            let decision = &self.decisions[child as usize];
            decision.surface / decision.cost
        };
        wide.children[..usize::from(wide.count)].sort_by(|&a, &b| promise(b).total_cmp(&promise(a)));
    }

    fn collect(&self, index: u32, trees: u8, wide: &mut Wide) {
        let choices = &self.decisions[index as usize].choices;
        match (2..=trees).rev().find(|&i| choices[usize::from(i)] != 0) {
            Some(i) => {
                let from_left = choices[usize::from(i)];
                let left = self.binary.nodes[index as usize].first_index;
                self.collect(left, from_left, wide);
                self.collect(left + 1, i - from_left, wide);
            }
            None => {
                wide.children[usize::from(wide.count)] = index;
                wide.count += 1;
            }
        }
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
