//! Nodes with eight children.

use super::space::LocalRay;
use super::traversal::Arrays;
use crate::math::simd::{F32x8, prefetch};
use bytemuck::{Pod, Zeroable};

/// A child: a node, a block of triangles, a mixed leaf, or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct NodeRef(u32);

/// What a [`NodeRef`] leads to if that is no node.
pub enum Leaf {
    Triangles(usize),
    Mixed(usize),
}

impl NodeRef {
    const KIND: u32 = 3 << 30;
    pub const ROOT: Self = Self(0);
    /// A missing child; its box is empty, so this is never followed.
    pub const EMPTY: Self = Self(u32::MAX);

    pub fn node(index: usize) -> Self {
        Self(index as u32)
    }

    pub const fn triangles(index: usize) -> Self {
        Self(index as u32 | 1 << 30)
    }

    pub const fn mixed(index: usize) -> Self {
        Self(index as u32 | 2 << 30)
    }

    /// Prefetches what this leads to.
    #[inline(always)]
    pub fn prefetch(self, arrays: &Arrays) {
        if let Some(index) = self.as_node() {
            prefetch(arrays.nodes, index);
        } else if let Leaf::Triangles(index) = self.leaf() {
            prefetch(arrays.triangles, index);
        }
    }

    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The index of the node that it leads to, if it is one.
    #[inline(always)]
    pub fn as_node(self) -> Option<usize> {
        (self.0 < Self::triangles(0).0).then_some(self.0 as usize)
    }

    /// What it leads to, if that is no node.
    #[inline(always)]
    pub fn leaf(self) -> Leaf {
        let index = (self.0 & !Self::KIND) as usize;
        if self.0 < Self::mixed(0).0 { Leaf::Triangles(index) } else { Leaf::Mixed(index) }
    }
}

/// Eight boxes and what is in them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Node {
    /// planes[side][axis][child], side 0 the lower.
    pub planes: [[[f32; 8]; 3]; 2],
    pub children: [NodeRef; 8],
}

impl Node {
    /// A node whose boxes are all empty.
    pub fn empty() -> Self {
        let planes = [[[f32::INFINITY; 8]; 3], [[f32::NEG_INFINITY; 8]; 3]];
        Self { planes, children: [NodeRef::EMPTY; 8] }
    }

    pub fn set(&mut self, child: usize, lo: [f32; 3], hi: [f32; 3], to: NodeRef) {
        for axis in 0..3 {
            self.planes[0][axis][child] = lo[axis];
            self.planes[1][axis][child] = hi[axis];
        }
        self.children[child] = to;
    }

    /// Half the surface areas of the boxes of children that are not missing.
    pub fn half_areas(&self) -> impl Iterator<Item = f32> {
        let area = |child: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| self.planes[1][axis][child] - self.planes[0][axis][child]);
            x * y + y * z + z * x
        };
        (0..8).filter(|child| self.children[*child] != NodeRef::EMPTY).map(area)
    }

    /// Which boxes the ray enters (a bit each) and where.
    #[inline(always)]
    pub fn intersect(&self, ray: &LocalRay) -> (u32, F32x8) {
        let mut entry = F32x8::splat(0.0);
        let mut exit = F32x8::splat(ray.limit);
        for axis in 0..3 {
            let negative = ray.negative[axis] & 1;
            let near = F32x8::new(&self.planes[negative][axis]);
            let far = F32x8::new(&self.planes[1 - negative][axis]);
            let origin = F32x8::splat(ray.origin[axis]);
            entry = ((near - origin) * F32x8::splat(ray.inverse[axis])).max(entry);
            exit = ((far - origin) * F32x8::splat(ray.far_inverse[axis])).min(exit);
        }
        (entry.at_most(exit), entry)
    }
}
