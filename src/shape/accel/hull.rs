//! The hull of a box and a point, and what reaches into it.

use super::node::{Node, NodeRef};
use super::space::Space;
use crate::math::simd::F32x8;
use crate::math::{Bounds, DVec3};

/// The hull of a box and a point, in unit coordinates, by planes: those of the box around both, and in each
/// projection along an axis the two lines from the point that touch the box.
pub struct Hull {
    lo: [f32; 3],
    hi: [f32; 3],
    to: [f32; 3],
    /// Pairs of axes, each with the normals of two lines that point inwards; zero where the point is in the
    /// projected box.
    tangents: [(usize, usize, [[f32; 2]; 2]); 3],
    /// How far outside a tangent a box must lie to be beside the hull.
    lost: f32,
}

/// A bound of the rounding error when a box is tested against a tangent, for a hull within the unit cube. The
/// point and the normal are rounded to `f32`, by 2⁻²⁵ each, with |nₐ| + |n_b| = 1 and at most 2 between point
/// and corner; two differences, two products and a sum lose 2⁻²⁴ of at most 2 each. A corner farther away
/// than the hull is large lies far inside of a tangent, or is not asked for: its box is beside the hull's.
const LOST: f32 = 1.0 / (1 << 20) as f32;

impl Hull {
    /// The hull of the box between two corners, and a point (world).
    pub fn new(space: &Space, bounds: Bounds, to: DVec3) -> Self {
        let (lo, hi) = space.enclose(bounds.0, bounds.1);
        let (near, far) = space.enclose(to, to);
        let at = space.local(to).to_array();
        let tangent = |a: usize, b: usize| {
            let (lo, hi, to) = ([lo[a], lo[b]].map(f64::from), [hi[a], hi[b]].map(f64::from), [at[a], at[b]]);
            let corners = [[lo[0], lo[1]], [hi[0], lo[1]], [lo[0], hi[1]], [hi[0], hi[1]]]
                .map(|c| [c[0] - to[0], c[1] - to[1]]);
            let mut normals = [[0.0; 2]; 2];
            for [x, y] in corners {
                let size = x.abs() + y.abs();
                let sides = corners.map(|c| x * c[1] - y * c[0]);
                let normal = [-y / size, x / size];
                if sides.iter().all(|side| *side >= 0.0) {
                    normals[0] = normal.map(|n| n as f32);
                }
                if sides.iter().all(|side| *side <= 0.0) {
                    normals[1] = normal.map(|n| -n as f32);
                }
            }
            (a, b, normals)
        };
        let lo: [f32; 3] = std::array::from_fn(|axis| lo[axis].min(near[axis]));
        let hi: [f32; 3] = std::array::from_fn(|axis| hi[axis].max(far[axis]));
        let size = lo.iter().chain(&hi).fold(1.0, |size: f32, x| size.max(x.abs()));
        Self {
            lo,
            hi,
            lost: LOST * size,
            to: at.map(|x| x as f32),
            tangents: [tangent(0, 1), tangent(1, 2), tangent(2, 0)],
        }
    }

    /// Whether a box in world space reaches into the hull, or comes near it.
    pub fn meets_box(&self, space: &Space, (lo, hi): (DVec3, DVec3)) -> bool {
        let mut node = Node::empty();
        let (lo, hi) = space.enclose(lo, hi);
        node.set(0, lo, hi, NodeRef::EMPTY);
        self.meets(&node) != 0
    }

    /// Which boxes of a node reach into the hull, a bit each; perhaps some that only come near it.
    #[inline]
    pub fn meets(&self, node: &Node) -> u32 {
        let plane = |side: usize, axis: usize| F32x8::new(&node.planes[side][axis]);
        let mut met = 255;
        for axis in 0..3 {
            met &= plane(0, axis).at_most(F32x8::splat(self.hi[axis]));
            met &= F32x8::splat(self.lo[axis]).at_most(plane(1, axis));
        }
        for (a, b, normals) in &self.tangents {
            for normal in normals {
                // The corner that lies farthest inwards.
                let part = |axis: usize, n: f32| {
                    (plane(usize::from(n >= 0.0), axis) - F32x8::splat(self.to[axis])) * F32x8::splat(n)
                };
                // Without a sum of eight lanes: x ≥ −y − lost.
                let rest = F32x8::splat(-self.lost) - part(*b, normal[1]);
                met &= rest.at_most(part(*a, normal[0]));
            }
        }
        met
    }
}
