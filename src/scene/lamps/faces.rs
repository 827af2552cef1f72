//! The flat sides of lamps, so that those near something are found quickly.

use super::facet::Facet;
use super::patches;
use crate::math::bounds::{NOTHING, union};
use crate::math::{Bounds, DVec3};
use crate::scene::Shape;
use crate::shape::Patch;

/// A side of a lamp that emits towards its front.
pub struct Face {
    /// The number of its shape.
    pub shape: usize,
    pub patch: Patch,
    bounds: Bounds,
}

impl Face {
    /// Whether it may lie in something in a box: a tilted face is not wherever its own box is.
    fn is_near(&self, bounds: Bounds, slack: f64) -> bool {
        let (centre, half) = (0.5 * bounds.0 + 0.5 * bounds.1, 0.5 * bounds.1 - 0.5 * bounds.0);
        let Patch { n, centre: on_plane, .. } = self.patch;
        meet(self.bounds, bounds, slack) && n.dot(centre - on_plane).abs() <= n.abs().dot(half) + slack
    }
}

/// Fewer faces than this are looked at one by one.
const FEW: usize = 8;

/// The sides of all lamps that are made of patches, in a binary tree.
pub struct Faces {
    /// Those of a node lie side by side, and those of its first half in its first child.
    faces: Vec<Face>,
    /// Each node before those of its first and then of its second child.
    nodes: Vec<Node>,
    /// The largest error of their points.
    pub error: f64,
}

struct Node {
    bounds: Bounds,
    /// The number of the second child, if there are children.
    second: usize,
}

/// Whether boxes come as near to each other as `slack` along every axis.
fn meet(a: Bounds, b: Bounds, slack: f64) -> bool {
    let slack = DVec3::splat(slack);
    (a.0 - slack).cmple(b.1).all() && b.0.cmple(a.1 + slack).all()
}

impl Faces {
    pub fn of(shapes: &[Shape]) -> Self {
        let lamps = shapes.iter().enumerate().filter(|(_, shape)| shape.emitter.is_some());
        let faces = lamps.flat_map(|(number, shape)| {
            let face = move |patch: &Patch| Face { shape: number, patch: *patch, bounds: patch.bounds() };
            patches(&shape.geometry).iter().map(face)
        });
        let mut faces: Vec<Face> = faces.collect();
        let mut nodes = vec![];
        grow(&mut faces, &mut nodes);
        let error = faces.iter().map(|face| face.patch.point_error()).fold(0.0, f64::max);
        Self { faces, nodes, error }
    }

    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Whether any may lie in something in a box (world).
    pub fn are_near(&self, bounds: Bounds, slack: f64) -> bool {
        self.any_below(0, &self.faces, bounds, slack)
    }

    fn any_below(&self, number: usize, faces: &[Face], bounds: Bounds, slack: f64) -> bool {
        let node = &self.nodes[number];
        if !meet(node.bounds, bounds, slack) {
            return false;
        }
        if faces.len() > FEW {
            let (first, second) = faces.split_at(faces.len() / 2);
            return self.any_below(number + 1, first, bounds, slack)
                || self.any_below(node.second, second, bounds, slack);
        }
        faces.iter().any(|face| face.is_near(bounds, slack))
    }

    /// Calls `f` with every face that lies in a facet, and how far it must be raised to lie upon it.
    pub fn each_in(&self, facet: &Facet, f: &mut impl FnMut(&Face, f64)) {
        self.each_below(0, &self.faces, facet, facet.rounding.slack(self.error), f);
    }

    fn each_below(
        &self,
        number: usize,
        faces: &[Face],
        facet: &Facet,
        slack: f64,
        f: &mut impl FnMut(&Face, f64),
    ) {
        let node = &self.nodes[number];
        if !meet(node.bounds, facet.bounds, slack) {
            return;
        }
        if faces.len() > FEW {
            let (first, second) = faces.split_at(faces.len() / 2);
            self.each_below(number + 1, first, facet, slack, f);
            self.each_below(node.second, second, facet, slack, f);
            return;
        }
        for face in faces.iter().filter(|face| meet(face.bounds, facet.bounds, slack)) {
            if let Some(height) = facet.height(&face.patch) {
                f(face, height);
            }
        }
    }
}

/// Orders faces so that halves are apart along the longest side of their box, again and again.
fn grow(faces: &mut [Face], nodes: &mut Vec<Node>) {
    let bounds = faces.iter().map(|face| face.bounds).fold(NOTHING, union);
    let number = nodes.len();
    nodes.push(Node { bounds, second: 0 });
    if faces.len() <= FEW {
        return;
    }
    let sides = bounds.1 - bounds.0;
    let axis = (0..3).fold(0, |longest, axis| if sides[axis] > sides[longest] { axis } else { longest });
    let middle = |face: &Face| face.bounds.0[axis] + face.bounds.1[axis];
    let half = faces.len() / 2;
    faces.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    let (first, second) = faces.split_at_mut(half);
    grow(first, nodes);
    nodes[number].second = nodes.len();
    grow(second, nodes);
}
