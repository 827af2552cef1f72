//! Shafts: a test that nothing lies between many points and one.
//!
//! All segments from points near each other to a common one lie in the hull of the one and a box around the
//! many. Where no primitive reaches into it, one test replaces as many shadow rays (Haines and Wallace 1991,
//! "Shaft Culling for Efficient Ray-Cast Radiosity"). "Not clear" decides nothing: then rays are needed.

use super::hull::Hull;
use super::node::{Leaf, Node, NodeRef};
use super::{Accel, Mixed};
use crate::math::bounds::around;
use crate::math::ray::position_error;
use crate::math::{Bounds, DVec3, bits, frame};

/// Most nodes that are visited; beyond, rays are assumed to be cheaper.
const PATIENCE: usize = 48;

/// The plane of a flat primitive.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    at: DVec3,
    /// Normal of unit length; NaN if the primitive has no area, which no comparison takes for one side.
    normal: DVec3,
}

impl Plane {
    /// The plane through `at` with a normal of any length.
    pub fn new(at: DVec3, normal: DVec3) -> Self {
        Self { at, normal: frame::unit(normal) }
    }

    pub fn of_corners([a, b, c]: [DVec3; 3]) -> Self {
        Self::new(a, (b - a).cross(c - a))
    }

    /// Height of a point above the plane.
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.at)
    }
}

/// The points of a shaft, and where they lie relative to planes.
#[derive(Default)]
pub struct Shaft {
    points: Vec<DVec3>,
    /// The corners of a box around them.
    bounds: Bounds,
    /// For primitives tested so far, the least and the largest height of the points above the plane.
    heights: Vec<(u32, [f64; 2])>,
    waiting: Vec<NodeRef>,
}

impl Shaft {
    /// Sets the points.
    pub fn begin(&mut self, points: impl Iterator<Item = DVec3>) {
        self.points.clear();
        self.points.extend(points);
        self.heights.clear();
        self.bounds = around(self.points.iter().copied());
    }

    /// How many points there are.
    pub fn count(&self) -> usize {
        self.points.len()
    }

    /// Whether all points and `to` lie on one side of a primitive's plane, or on it as far as rounding lets
    /// one tell.
    fn is_beside(&mut self, primitive: u32, plane: &Plane, to: DVec3) -> bool {
        let known = self.heights.iter().find(|known| known.0 == primitive);
        let [least, most] = known.map(|known| known.1).unwrap_or_else(|| {
            let start = [f64::INFINITY, f64::NEG_INFINITY];
            let heights =
                self.points.iter().map(|p| plane.height(*p)).fold(start, |[least, most], height| {
                    // Unlike `f64::min`, this lets a NaN stay.
                    [if height >= least { least } else { height }, if height <= most { most } else { height }]
                });
            self.heights.push((primitive, heights));
            heights
        });
        let farthest = self.bounds.0.abs().max(self.bounds.1.abs()).max(to.abs());
        let error = 4.0 * (position_error(farthest) + position_error(plane.at));
        let height = plane.height(to);
        (least >= -error && height >= -error) || (most <= error && height <= error)
    }
}

/// Primitives outside the tree, for shafts.
#[derive(Default)]
pub struct Few {
    pub boxes: Vec<Node>,
    /// Number of each primitive, in the order of the boxes, and its plane if it is flat.
    pub primitives: Vec<(u32, Option<Plane>)>,
}

/// A test whether something lies between the points of a shaft and `to`, which lies on primitive `on`.
struct Question<'a> {
    shaft: &'a mut Shaft,
    hull: Hull,
    to: DVec3,
    on: u32,
}

impl Question<'_> {
    /// Whether a flat primitive cannot lie between them.
    fn is_beside(&mut self, (primitive, plane): (u32, Plane)) -> bool {
        primitive == self.on || self.shaft.is_beside(primitive, &plane, self.to)
    }
}

impl Accel {
    /// Whether nothing can lie between `to` and any of the points. `to` lies on primitive `on`, which cannot
    /// if it is flat.
    pub fn is_clear(&self, shaft: &mut Shaft, to: DVec3, on: u32) -> bool {
        let hull = Hull::new(&self.space, shaft.bounds, to);
        let mut waiting = std::mem::take(&mut shaft.waiting);
        let mut question = Question { shaft, hull, to, on };
        let clear = self.outside_tree.few.is_clear(&mut question)
            && (self.nodes.is_empty() || self.tree_is_clear(&mut question, &mut waiting));
        shaft.waiting = waiting;
        clear
    }

    fn tree_is_clear(&self, question: &mut Question, waiting: &mut Vec<NodeRef>) -> bool {
        waiting.clear();
        waiting.push(NodeRef::ROOT);
        for _ in 0..PATIENCE {
            let Some(next) = waiting.pop() else { return true };
            if let Some(index) = next.as_node() {
                let node = &self.nodes[index];
                let met = bits::numbers(question.hull.meets(node).into());
                waiting.extend(met.map(|lane| node.children[lane]));
                continue;
            }
            let beside = match next.leaf() {
                Leaf::Triangles(index) => self.block_is_beside(index, question),
                Leaf::Mixed(index) => self.mixed_is_beside(&self.mixed[index], question),
            };
            if !beside {
                return false;
            }
        }
        false
    }

    fn block_is_beside(&self, block: usize, question: &mut Question) -> bool {
        self.triangles[block].corners().all(|(primitive, corners)| {
            question.is_beside((primitive, Plane::of_corners(corners))) || {
                let [a, b, c] = corners;
                !question.hull.meets_box(&self.space, (a.min(b).min(c), a.max(b).max(c)))
            }
        })
    }

    fn mixed_is_beside(&self, mixed: &Mixed, question: &mut Question) -> bool {
        let block = |block: Option<u32>| block.map(|block| block as usize);
        let spheres = block(mixed.spheres).into_iter().flat_map(|block| self.spheres[block].bounds());
        let cylinders = block(mixed.cylinders).into_iter().flat_map(|block| self.cylinders[block].bounds());
        let instances = mixed.instances.iter().map(|i| self.instances[*i as usize].bounds());
        let mut round = spheres.chain(cylinders).chain(instances);
        let patches = block(mixed.patches).into_iter().flat_map(|block| self.patches[block].outlines());
        let cubes = block(mixed.cubes).into_iter().flat_map(|block| self.cubes[block].faces());
        let mut flat = patches.chain(cubes);
        round.all(|bounds| !question.hull.meets_box(&self.space, bounds))
            && flat.all(|(primitive, plane, bounds)| {
                question.is_beside((primitive, plane)) || !question.hull.meets_box(&self.space, bounds)
            })
            && block(mixed.triangles).is_none_or(|block| self.block_is_beside(block, question))
    }
}

impl Few {
    fn is_clear(&self, question: &mut Question) -> bool {
        self.boxes.iter().zip(self.primitives.chunks(8)).all(|(node, primitives)| {
            bits::numbers(question.hull.meets(node).into()).all(|lane| {
                let (primitive, plane) = primitives[lane];
                plane.is_some_and(|plane| question.is_beside((primitive, plane)))
            })
        })
    }
}

#[cfg(test)]
mod tests;
