//! A tree of emitters, for scenes with many: one is chosen by an estimate of its contribution at the point
//! where light is gathered.
//!
//! Every node stores for each of its children where the emitters are, in which directions they emit, and
//! how much ([`Cluster`]), from which follow estimates of the light that they contribute at a point. A
//! choice descends from the root, at each node to one of the children with a probability in proportion to
//! these estimates (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting"; PBRT, 4th edition, §12.6.3). The estimate for an emitter that may light the point is never
//! zero, so no light is lost, however wrong it is.

mod build;
mod children;
mod cluster;

use super::GatherPoint;
use crate::math::{BELOW_ONE, Chosen};
use children::{Children, Importance, WIDTH};
pub use cluster::Cluster;

/// A tree of which every leaf is an emitter.
#[derive(Debug)]
pub struct Tree {
    /// The root comes first.
    nodes: Vec<Node>,
    /// The leaf of each emitter, by its number.
    leaves: Vec<Place>,
}

#[derive(Debug)]
struct Node {
    children: Children,
    targets: [Target; WIDTH],
    /// Where the node is among its parent's children; `None` for the root.
    place: Option<Place>,
}

#[derive(Clone, Copy, Debug)]
enum Target {
    /// No child: it has no power, so it is never chosen.
    Nothing,
    Emitter(u32),
    Node(u32),
}

/// One of a node's children.
#[derive(Clone, Copy, Debug)]
struct Place {
    node: u32,
    child: u32,
}

impl Tree {
    /// A tree of at least one emitter.
    pub fn new(clusters: &[Cluster]) -> Self {
        build::build(clusters)
    }

    /// Estimates of what each child of the root brings to a point.
    #[inline]
    pub fn seen_from<'a>(&self, at: GatherPoint<'a>) -> SeenTree<'a> {
        SeenTree { at, root: self.nodes[0].children.importance(at) }
    }

    /// The emitter that a number in [0, 1) falls on as seen from a point; `None` if no emitter lights the point.
    pub fn sample(&self, seen: &SeenTree, mut u: f64) -> Option<Chosen> {
        let (mut index, mut probability) = (0, 1.0);
        let (mut importance, mut total) = seen.root;
        loop {
            let (mut child, mut left) = (0, u * total);
            while child + 1 < WIDTH && left >= importance[child] {
                left -= importance[child];
                child += 1;
            }
            probability *= importance[child] / total;
            // Rounding may lead past the last that can light the point.
            if probability.is_nan() || probability <= 0.0 {
                return None;
            }
            u = (left / importance[child]).min(BELOW_ONE);
            match self.nodes[index].targets[child] {
                Target::Emitter(emitter) => {
                    return Some(Chosen { index: emitter as usize, probability, rest: u });
                }
                Target::Node(next) => index = next as usize,
                Target::Nothing => return None,
            }
            (importance, total) = self.nodes[index].children.importance(seen.at);
        }
    }

    /// The probability of choosing an emitter as seen from a point.
    pub fn probability(&self, seen: &SeenTree, emitter: usize) -> f64 {
        let mut probability = 1.0;
        let mut place = Some(self.leaves[emitter]);
        while let Some(Place { node: number, child }) = place {
            let node = &self.nodes[number as usize];
            let (importance, total) = if number == 0 { seen.root } else { node.children.importance(seen.at) };
            if importance[child as usize] <= 0.0 {
                return 0.0;
            }
            probability *= importance[child as usize] / total;
            place = node.place;
        }
        probability
    }
}

/// A tree as seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct SeenTree<'a> {
    at: GatherPoint<'a>,
    root: Importance,
}

impl SeenTree<'_> {
    /// An estimate of the irradiance from all emitters; zero only if none lights the point.
    #[inline]
    pub fn total(&self) -> f64 {
        self.root.1
    }
}

#[cfg(test)]
mod tests;
