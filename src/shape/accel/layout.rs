//! The nodes of eight of a planned tree, and their order in memory.

use super::collapse::{Decision, Plan};
use super::node::{Node, NodeRef};
use rayon::prelude::*;
use std::collections::VecDeque;

/// At least as many subtrees of a large tree are laid out side by side, if it has them level by level: enough for any
/// number of threads although their sizes differ.
const PARTS: usize = 64;

/// All nodes, the children of each next to each other, and all leaves.
pub struct Layout {
    pub nodes: Vec<Wide>,
    /// The leaves with triangles, which are in blocks: here and below, leaves are the binary nodes that become them.
    pub blocks: Vec<u32>,
    /// The leaves with anything else.
    pub mixed: Vec<MixedLeaf>,
}

pub struct MixedLeaf {
    pub leaf: u32,
    /// The block of its triangles.
    pub triangles: Option<u32>,
}

/// A node of eight that is planned.
#[derive(Default)]
pub struct Wide {
    /// Binary nodes that become its children, the most promising for a shadow ray first.
    children: [u32; 8],
    count: u8,
    first: First,
}

/// Where the first children of a node are: those that are nodes, blocks of triangles and mixed leaves.
#[derive(Clone, Copy, Default)]
struct First {
    node: u32,
    block: u32,
    mixed: u32,
}

impl Layout {
    pub fn new(plan: &Plan) -> Self {
        let mut layout = Self::root();
        let mut waiting = VecDeque::from([(0, 0)]);
        let parts = if plan.is_large() { PARTS } else { 1 };
        while waiting.len() < parts
            && let Some((index, to)) = waiting.pop_front()
        {
            layout.add(plan, index, to, &mut waiting);
        }
        let parts: Vec<Self> = waiting.par_iter().map(|&(index, _)| Self::of_subtree(plan, index)).collect();
        layout.nodes.reserve(parts.iter().map(|part| part.nodes.len()).sum());
        layout.blocks.reserve(parts.iter().map(|part| part.blocks.len()).sum());
        for (part, (_, to)) in parts.into_iter().zip(waiting) {
            layout.append(part, to);
        }
        layout
    }

    fn root() -> Self {
        Self { nodes: vec![Wide::default()], blocks: vec![], mixed: vec![] }
    }

    /// Of all below a binary node, depth first.
    fn of_subtree(plan: &Plan, root: u32) -> Self {
        let mut layout = Self::root();
        let mut waiting = vec![(root, 0)];
        while let Some((index, to)) = waiting.pop() {
            layout.add(plan, index, to, &mut waiting);
        }
        layout
    }

    /// Makes node `to` of a binary node. What is to become of its children that are nodes is added to `waiting`.
    fn add(&mut self, plan: &Plan, index: u32, to: usize, waiting: &mut impl Extend<(u32, usize)>) {
        let mut next = self.end();
        let wide = Wide { first: next, ..Wide::of(plan, index) };
        for &child in wide.children() {
            let First { node, block, mixed } = next;
            next.take(plan.decision(child));
            if next.node > node {
                waiting.extend([(child, node as usize)]);
                self.nodes.push(Wide::default());
            }
            let triangles = (next.block > block).then_some(block);
            self.blocks.extend(triangles.map(|_| child));
            if next.mixed > mixed {
                self.mixed.push(MixedLeaf { leaf: child, triangles });
            }
        }
        self.nodes[to] = wide;
    }

    /// Where what is added next will be.
    fn end(&self) -> First {
        First {
            node: self.nodes.len() as u32,
            block: self.blocks.len() as u32,
            mixed: self.mixed.len() as u32,
        }
    }

    /// Adds the layout of a subtree, whose root becomes node `to`.
    fn append(&mut self, part: Self, to: usize) {
        let end = self.end();
        let moved = |wide: Wide| {
            let First { node, block, mixed } = wide.first;
            // The root is not among the nodes at the end.
            let node = end.node + node - 1;
            Wide { first: First { node, block: end.block + block, mixed: end.mixed + mixed }, ..wide }
        };
        let mut moved = part.nodes.into_iter().map(moved);
        self.nodes[to] = moved.next().unwrap_or_default();
        self.nodes.extend(moved);
        self.blocks.extend(part.blocks);
        self.mixed.extend(part.mixed.into_iter().map(|mut mixed| {
            mixed.triangles = mixed.triangles.map(|block| end.block + block);
            mixed
        }));
    }
}

impl Wide {
    /// The node made of a binary node, without the places of its children.
    fn of(plan: &Plan, index: u32) -> Self {
        let mut wide = Self::default();
        let node = &plan.binary.nodes[index as usize];
        if node.is_leaf() {
            wide.collect(plan, index, 1);
        } else {
            let from_left = plan.decision(index).choices[0];
            wide.collect(plan, node.first_index, from_left);
            wide.collect(plan, node.first_index + 1, 8 - from_left);
        }
        let promise = |child: u32| plan.decision(child).promise();
        wide.children[..usize::from(wide.count)].sort_by(|&a, &b| promise(b).total_cmp(&promise(a)));
        wide
    }

    fn children(&self) -> &[u32] {
        &self.children[..usize::from(self.count)]
    }

    /// Finds at most so many children below a binary node.
    fn collect(&mut self, plan: &Plan, index: u32, trees: u8) {
        let choices = plan.decision(index).choices;
        match (2..=trees).rev().find(|&i| choices[usize::from(i)] != 0) {
            Some(i) => {
                let from_left = choices[usize::from(i)];
                let left = plan.binary.nodes[index as usize].first_index;
                self.collect(plan, left, from_left);
                self.collect(plan, left + 1, i - from_left);
            }
            None => {
                self.children[usize::from(self.count)] = index;
                self.count += 1;
            }
        }
    }

    /// The finished node.
    pub fn node(&self, plan: &Plan) -> Node {
        let mut node = Node::empty();
        let mut next = self.first;
        for (slot, &child) in self.children().iter().enumerate() {
            let target = next.take(plan.decision(child));
            let aabb = plan.binary.nodes[child as usize].aabb();
            node.set(slot, aabb.min.to_array(), aabb.max.to_array(), target);
        }
        node
    }
}

impl First {
    /// Where a child is; the next of its kind comes behind it.
    fn take(&mut self, child: Decision) -> NodeRef {
        let First { node, block, mixed } = *self;
        if !child.is_leaf() {
            self.node += 1;
            return NodeRef::node(node as usize);
        }
        self.block += u32::from(child.has_triangles());
        if child.only_triangles() {
            return NodeRef::triangles(block as usize);
        }
        self.mixed += 1;
        NodeRef::mixed(mixed as usize)
    }
}
