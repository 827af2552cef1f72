//! Four triangles at a time, watertight (Woop, Benthin & Wald 2013).
//!
//! The ray is sheared to the z axis and the edge functions are evaluated in `f64` from `f32` vertices. The
//! function of an edge shared by two triangles is computed from the same numbers in both, with the sign
//! exactly reversed, so a ray through the edge meets at least one.

use super::Search;
use crate::math::ray::NO_PRIMITIVE;
use crate::math::simd::F64x4;
use crate::math::{DVec3, Ray};
use bytemuck::{Pod, Zeroable};
use glam::Vec3Swizzles;

/// A hit no farther from the ray's start than this fraction of the extent of all triangles is computed again:
/// see [`Triangles::near`]. It leaves room for needles as long as that extent and as 2²⁶ widths.
pub const NEAR: f64 = 1.0 / (1u64 << 24) as f64;

/// A ray's origin and shear, with its axes permuted so that the direction is largest along the third.
pub struct Sheared {
    axes: [usize; 3],
    origin: [f64; 3],
    shear: [f64; 3],
    /// A distance that is smaller than this is before the ray's start, whatever rounding does.
    least: f64,
    /// A distance that is smaller than this is computed again.
    sure: f64,
}

impl Sheared {
    #[inline(always)]
    pub fn new(ray: &Ray, near: f64) -> Self {
        let d = ray.direction.to_array();
        let size = ray.direction.abs();
        let z = if size.x > size.y {
            if size.x > size.z { 0 } else { 2 }
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let o = ray.origin.to_array();
        let inverse = 1.0 / d[z];
        Self {
            axes,
            origin: axes.map(|a| o[a]),
            shear: [d[axes[0]] * inverse, d[axes[1]] * inverse, inverse],
            least: ray.start - near,
            sure: ray.start + near,
        }
    }
}

/// Four triangles; missing ones have no area.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Triangles {
    /// vertices[corner][axis][triangle].
    vertices: [[[f32; 4]; 3]; 3],
    primitives: [u32; 4],
}

impl Triangles {
    pub fn empty() -> Self {
        Self { vertices: [[[0.0; 4]; 3]; 3], primitives: [NO_PRIMITIVE; 4] }
    }

    pub fn set(&mut self, lane: usize, corners: [[f32; 3]; 3], primitive: u32) {
        for (vertex, corner) in self.vertices.iter_mut().zip(corners) {
            for (lanes, coordinate) in vertex.iter_mut().zip(corner) {
                lanes[lane] = coordinate;
            }
        }
        self.primitives[lane] = primitive;
    }

    /// Each triangle's number and corners.
    pub fn corners(&self) -> impl Iterator<Item = (u32, [DVec3; 3])> {
        let there = (0..4).filter(|&lane| self.primitives[lane] != NO_PRIMITIVE);
        there.map(move |lane| (self.primitives[lane], [0, 1, 2].map(|i| self.corner(i, lane))))
    }

    fn corner(&self, i: usize, lane: usize) -> DVec3 {
        DVec3::from_array(self.vertices[i].map(|axis| f64::from(axis[lane])))
    }

    /// How many there are.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.primitives.iter().filter(|&&primitive| primitive != NO_PRIMITIVE).count()
    }

    pub fn holds(&self, primitive: u32) -> bool {
        self.primitives.contains(&primitive)
    }

    /// The distance of a triangle that is hit next to the ray's start, if it is beyond the start whatever the
    /// rounding errors are.
    ///
    /// [`Self::intersect`]'s distance is a mean of those of the corners. If it is small beside them, its
    /// terms cancel, and what is left is as wrong as the weights: by 2⁻⁵³ of the length over the width, which
    /// for a needle a million times as long as wide is 10⁻¹⁰ of its length. The distance from the plane, n·(a
    /// − o)/n·ω, is wrong by less, and it is known by how much.
    #[inline(always)]
    fn near(&self, lane: usize, ray: &Ray) -> Option<f64> {
        // A bound for two differences, a product of two and a difference of those, a third difference, and a
        // sum of three products.
        const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
        let [a, b, c] = [0, 1, 2].map(|i| self.corner(i, lane));
        let (ab, ac, way) = (b - a, c - a, a - ray.origin);
        let n = ab.cross(ac);
        let (p, q) = (ab.abs(), ac.abs());
        let terms = p.yzx() * q.zxy() + p.zxy() * q.yzx();
        let cos = n.dot(ray.direction);
        let (t, error) = (n.dot(way) / cos, ROUNDINGS * terms.dot(way.abs()) / cos.abs());
        (t > ray.start + error).then_some(t)
    }

    #[inline(always)]
    pub fn intersect(&self, ray: &Sheared, search: &mut Search) {
        let origin = ray.origin.map(F64x4::splat);
        let shear = ray.shear.map(F64x4::splat);
        let corner = |vertex: &[[f32; 4]; 3]| {
            let [x, y, z] = ray.axes.map(|axis| F64x4::widen(&vertex[axis]));
            let z = z - origin[2];
            [(x - origin[0]) - shear[0] * z, (y - origin[1]) - shear[1] * z, z]
        };
        let [a, b, c] = [0, 1, 2].map(|i| corner(&self.vertices[i]));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let zero = F64x4::splat(0.0);
        let mut inside = (zero.at_most(u.min(v).min(w)) | u.max(v).max(w).at_most(zero)).bits();
        if inside == 0 {
            return;
        }
        let determinant = u + v + w;
        let t = (u * a[2] + v * b[2] + w * c[2]) * shear[2] / determinant;
        // No area makes a NaN or an infinity, and neither comes before the best.
        let ahead = F64x4::splat(ray.least).below(t) & t.at_most(F64x4::splat(search.best.t));
        inside &= ahead.bits();
        if inside == 0 {
            return;
        }
        let (t, v, w, determinant) = (t.to_array(), v.to_array(), w.to_array(), determinant.to_array());
        while inside != 0 {
            let i = inside.trailing_zeros() as usize;
            inside &= inside - 1;
            if self.primitives[i] == search.ray.from || determinant[i] == 0.0 {
                continue;
            }
            let t = if t[i] < ray.sure { self.near(i, search.ray) } else { Some(t[i]) };
            if let Some(t) = t {
                search.offer(t, v[i] / determinant[i], w[i] / determinant[i], self.primitives[i]);
            }
        }
    }
}
