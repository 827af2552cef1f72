//! A binary tree from the top down.
//!
//! Boxes are divided in two, and the halves again, each time where [`bins`](super::bins) finds it cheapest.
//! No step depends on the order of work, so the tree is the same for any number of threads.

use super::bins::{Place, Pricing, divide};
use crate::pages::Pages;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;

/// Most boxes that one thread divides.
const OF_ONE_THREAD: usize = 1 << 14;

/// A part of the tree.
enum Part {
    Fork(Fork),
    /// A subtree as a list of nodes: first the root, then children in pairs.
    Subtree(Vec<Bvh2Node>),
}

struct Fork {
    bounds: Aabb,
    children: Box<[Part; 2]>,
    /// Number of nodes below.
    below: usize,
}

impl Part {
    /// Number of nodes below the root.
    fn below(&self) -> usize {
        match self {
            Self::Fork(fork) => fork.below,
            Self::Subtree(nodes) => nodes.len() - 1,
        }
    }
}

/// Boxes that are not divided yet.
struct Undivided<'a> {
    boxes: &'a mut [Aabb],
    /// The item of each box.
    items: &'a mut [u32],
    /// How many boxes lie before these in the whole list.
    before: usize,
    place: Place,
    pricing: Pricing,
}

impl<'a> Undivided<'a> {
    // Not inlined: bins would take room on the stack at every level of the tree.
    #[inline(never)]
    fn halves(self) -> [Self; 2] {
        let Self { before, pricing, .. } = self;
        let (at, places) = divide(self.boxes, self.items, &self.place, pricing);
        let (boxes, items) = (self.boxes.split_at_mut(at), self.items.split_at_mut(at));
        [
            Undivided { boxes: boxes.0, items: items.0, before, place: places[0], pricing },
            Undivided { boxes: boxes.1, items: items.1, before: before + at, place: places[1], pricing },
        ]
    }

    fn leaf(&self) -> Bvh2Node {
        Bvh2Node::new(self.place.bounds, self.boxes.len() as u32, self.before as u32)
    }
}

/// The tree over `boxes`, at least one, which are around `items`. Leaves hold up to `most`, and no less where
/// they can.
pub fn grow(mut boxes: Pages<Aabb>, mut items: Vec<u32>, most: usize) -> Bvh2 {
    let chunks = boxes.par_chunks(OF_ONE_THREAD).map(Place::of);
    let place = chunks.reduce(|| Place::NOTHING, |one, other| one.and(&other));
    let pricing = Pricing::of(boxes.len());
    let part = part(Undivided { boxes: &mut boxes, items: &mut items, before: 0, place, pricing }, most);
    // Trees of millions of triangles are where memory runs out.
    drop(boxes);
    // Zeros are the system's, so that pages are first touched by the threads that write them.
    let mut nodes: Vec<Bvh2Node> = bytemuck::zeroed_vec(1 + part.below());
    if let Some((root, below)) = nodes.split_first_mut() {
        *root = join(part, below, 1);
    }
    Bvh2 { nodes, primitive_indices: items, ..Bvh2::default() }
}

fn part(undivided: Undivided, most: usize) -> Part {
    if undivided.boxes.len() <= OF_ONE_THREAD {
        return Part::Subtree(subtree(undivided, most));
    }
    let bounds = undivided.place.bounds;
    let [left, right] = undivided.halves();
    let (left, right) = rayon::join(|| part(left, most), || part(right, most));
    let below = 2 + left.below() + right.below();
    Part::Fork(Fork { bounds, children: Box::new([left, right]), below })
}

fn subtree(undivided: Undivided, most: usize) -> Vec<Bvh2Node> {
    // Most leaves are not quite full.
    let mut nodes = Vec::with_capacity(5 * undivided.boxes.len() / (2 * most) + 1);
    nodes.push(Bvh2Node::default());
    let mut waiting = vec![(0, undivided)];
    while let Some((to, undivided)) = waiting.pop() {
        if undivided.boxes.len() <= most {
            nodes[to] = undivided.leaf();
            continue;
        }
        let children = nodes.len();
        nodes[to] = Bvh2Node::new(undivided.place.bounds, 0, children as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        let [left, right] = undivided.halves();
        waiting.extend([(children + 1, right), (children, left)]);
    }
    nodes
}

/// Writes all nodes below the root of a part, whose first will have index `at`; returns the root.
fn join(part: Part, below: &mut [Bvh2Node], at: usize) -> Bvh2Node {
    match part {
        Part::Fork(Fork { bounds, children, .. }) => {
            let [left, right] = *children;
            let (roots, below) = below.split_at_mut(2);
            let (below_left, below_right) = below.split_at_mut(left.below());
            let at_right = at + 2 + below_left.len();
            (roots[0], roots[1]) =
                rayon::join(|| join(left, below_left, at + 2), || join(right, below_right, at_right));
            Bvh2Node::new(bounds, 0, at as u32)
        }
        Part::Subtree(nodes) => {
            let moved = |mut node: Bvh2Node| {
                if !node.is_leaf() {
                    // The root is not among them.
                    node.first_index += at as u32 - 1;
                }
                node
            };
            below.iter_mut().zip(&nodes[1..]).for_each(|(to, node)| *to = moved(*node));
            moved(nodes[0])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::accel::bins::around;
    use glam::Vec3A;
    use rand_pcg::{Pcg32, rand_core::Rng};

    const MOST: usize = 4;

    /// Small boxes in the unit cube.
    fn small_boxes(count: usize) -> Vec<Aabb> {
        let mut rng = Pcg32::new(0, 1);
        let mut uniform = || rng.next_u32() as f32 / 4294967296.0;
        let mut corner = || Vec3A::new(uniform(), uniform(), uniform());
        (0..count).map(|_| (corner(), 0.01 * corner())).map(|(at, size)| Aabb::new(at, at + size)).collect()
    }

    fn tree(boxes: &[Aabb]) -> Bvh2 {
        let mut pages = Pages::zeroed(boxes.len());
        pages.copy_from_slice(boxes);
        grow(pages, (0..boxes.len() as u32).collect(), MOST)
    }

    /// Looks at every node; answers with the number of levels.
    fn check(tree: &Bvh2, boxes: &[Aabb]) -> usize {
        let mut found = vec![0; boxes.len()];
        let mut levels = 0;
        let mut waiting = vec![(0, 1)];
        while let Some((node, level)) = waiting.pop() {
            let node = &tree.nodes[node];
            levels = levels.max(level);
            let first = node.first_index as usize;
            let inside: Vec<Aabb> = if node.is_leaf() {
                let count = node.prim_count as usize;
                assert!((1..=MOST).contains(&count), "{count} in a leaf");
                let items = tree.primitive_indices[first..first + count].iter().map(|&i| i as usize);
                items.clone().for_each(|item| found[item] += 1);
                items.map(|item| boxes[item]).collect()
            } else {
                waiting.extend([(first, level + 1), (first + 1, level + 1)]);
                tree.nodes[first..first + 2].iter().map(|child| *child.aabb()).collect()
            };
            let needed = around(&inside);
            assert_eq!((node.aabb().min, node.aabb().max), (needed.min, needed.max));
        }
        assert!(found.iter().all(|&times| times == 1));
        levels
    }

    #[test]
    fn every_box_is_in_one_leaf_and_in_all_nodes_above() {
        for count in [1, 2, 4, 5, 9, 17, 65, 1000, 3 * OF_ONE_THREAD] {
            let boxes = small_boxes(count);
            let levels = check(&tree(&boxes), &boxes);
            assert!(levels <= 2 + 2 * count.ilog2() as usize, "{levels} levels for {count}");
        }
    }

    #[test]
    fn leaves_of_large_trees_are_fuller() {
        let boxes = small_boxes((1 << 17) + 1);
        let leaves = |boxes: &[Aabb]| tree(boxes).nodes.iter().filter(|node| node.is_leaf()).count() as f64;
        let [large, small] = [&boxes[..], &boxes[1..]].map(leaves);
        assert!(large < 0.97 * small && small < 0.32 * boxes.len() as f64, "{large} {small}");
    }

    #[test]
    fn boxes_in_one_place_and_ever_nearer_to_one_are_divided() {
        let same = vec![small_boxes(1)[0]; 3 * OF_ONE_THREAD];
        assert!(check(&tree(&same), &same) <= 16);
        let at = |i: i32| Vec3A::splat(libm::exp2f(-(i % 140) as f32));
        let nearer: Vec<Aabb> = (0..40_000).map(|i| Aabb::new(at(i), at(i))).collect();
        assert!(check(&tree(&nearer), &nearer) < 150);
    }

    #[test]
    fn threads_change_nothing() {
        let boxes = small_boxes(200_000);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let tree = pool.install(|| tree(&boxes));
            let nodes =
                tree.nodes.iter().map(|n| (n.min.to_array(), n.max.to_array(), n.first_index, n.prim_count));
            (nodes.collect::<Vec<_>>(), tree.primitive_indices.clone())
        };
        assert!(with(1) == with(3));
    }

    #[test]
    fn walls_are_kept_from_what_stands_between_them() {
        let mut boxes: Vec<Aabb> =
            small_boxes(5000).iter().map(|b| Aabb::new(b.min + Vec3A::ONE, b.max + Vec3A::ONE)).collect();
        let room = Vec3A::splat(3.0);
        for axis in 0..3 {
            // All of a wall's coordinate along the axis is one number.
            let (mut near, mut far) = (room, Vec3A::ZERO);
            (near[axis], far[axis]) = (0.0, room[axis]);
            boxes.extend([Aabb::new(Vec3A::ZERO, near), Aabb::new(far, room)]);
        }
        // The middle of the floor is below what stands there.
        boxes.push(Aabb::new(Vec3A::new(0.0, 1.4, 0.0), Vec3A::new(3.0, 1.6, 3.0)));
        let tree = tree(&boxes);
        check(&tree, &boxes);
        let root = tree.nodes[0].first_index as usize;
        let areas = [0, 1].map(|i| tree.nodes[root + i].aabb().half_area());
        assert!(areas[0].min(areas[1]) < 4.0, "{areas:?}");
    }
}
