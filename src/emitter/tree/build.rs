//! How emitters are put into a tree: from the top, by planes across the axes, where the sides together
//! [cost](Cluster::cost) least.

use super::children::{Children, WIDTH};
use super::{Cluster, Node, Place, Target, Tree};
use crate::math::DVec3;

/// Bins along each axis: one more than the planes that are tried.
const BINS: usize = 12;

/// An emitter's number and the emitter as a cluster.
type Numbered = (u32, Cluster);

/// A tree over at least one cluster.
pub fn build(clusters: &[Cluster]) -> Tree {
    let mut numbered: Vec<Numbered> = (0..).zip(clusters.iter().copied()).collect();
    let mut tree = Tree { nodes: vec![], leaves: vec![Place { node: 0, child: 0 }; clusters.len()] };
    grow(&mut tree, &mut numbered, None);
    tree
}

/// Adds the nodes of some emitters; returns the index of the first.
fn grow(tree: &mut Tree, emitters: &mut [Numbered], place: Option<Place>) -> u32 {
    let mut groups = vec![(all(emitters), emitters)];
    while groups.len() < WIDTH {
        let costs = groups.iter().map(|(cluster, group)| if group.len() > 1 { cluster.cost() } else { -1.0 });
        let Some((dearest, cost)) = costs.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        if cost < 0.0 {
            break;
        }
        let (_, group) = groups.swap_remove(dearest);
        let middle = halve(group);
        let (first, second) = group.split_at_mut(middle);
        groups.extend([first, second].map(|group| (all(group), group)));
    }
    let node = tree.nodes.len() as u32;
    let clusters: Vec<Cluster> = groups.iter().map(|(cluster, _)| *cluster).collect();
    let targets = [Target::Nothing; WIDTH];
    tree.nodes.push(Node { children: Children::new(&clusters), targets, place });
    for (child, (_, group)) in (0..).zip(groups) {
        let place = Place { node, child };
        let target = match group {
            [(emitter, _)] => {
                tree.leaves[*emitter as usize] = place;
                Target::Emitter(*emitter)
            }
            _ => Target::Node(grow(tree, group, Some(place))),
        };
        tree.nodes[node as usize].targets[child as usize] = target;
    }
    node
}

/// The cluster of some emitters, of which there is at least one.
fn all(emitters: &[Numbered]) -> Cluster {
    emitters[1..].iter().fold(emitters[0].1, |sum, (_, cluster)| Cluster::union(sum, *cluster))
}

/// Sorts emitters into two sides; returns how many are on the first.
fn halve(emitters: &mut [Numbered]) -> usize {
    let (lo, hi) = crate::math::bounds::around(emitters.iter().map(|(_, cluster)| cluster.ball().0));
    let extent = hi - lo;
    let bin = |axis: usize, centre: DVec3| {
        let place = (centre[axis] - lo[axis]) / extent[axis];
        ((place * BINS as f64) as usize).min(BINS - 1)
    };
    // The least cost, with its axis and the first bin of the second side.
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|axis| extent[*axis] > 0.0) {
        let mut bins: [Option<Cluster>; BINS] = [None; BINS];
        for (_, cluster) in emitters.iter() {
            let of = &mut bins[bin(axis, cluster.ball().0)];
            *of = joined(*of, Some(*cluster));
        }
        let mut above = [None; BINS];
        for i in (0..BINS - 1).rev() {
            above[i] = joined(bins[i + 1], above[i + 1]);
        }
        let mut below = None;
        for i in 0..BINS - 1 {
            below = joined(below, bins[i]);
            let (Some(a), Some(b)) = (below, above[i]) else { continue };
            // Splits across a short axis leave long boxes.
            let cost = (a.cost() + b.cost()) * (extent.max_element() / extent[axis]);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, i + 1));
            }
        }
    }
    let Some((_, axis, first_above)) = best else { return emitters.len() / 2 };
    let is_below = |(_, cluster): &Numbered| bin(axis, cluster.ball().0) < first_above;
    emitters.sort_by_key(|emitter| !is_below(emitter));
    emitters.partition_point(is_below)
}

fn joined(a: Option<Cluster>, b: Option<Cluster>) -> Option<Cluster> {
    match (a, b) {
        (Some(a), Some(b)) => Some(Cluster::union(a, b)),
        (a, b) => a.or(b),
    }
}
