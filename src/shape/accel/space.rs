//! The coordinates of the boxes: what the tree holds, moved and scaled by a power of two into the unit cube.

use crate::math::bounds::half_extent;
use crate::math::function::{ilogb, scalbn};
use crate::math::{Bounds, DVec3, Ray};

/// Boxes are widened by this fraction of what the tree holds. It covers the error of a ray that is rounded to `f32` in
/// unit coordinates: 2⁻²⁵ of its origin, and 2⁻²⁴ of its direction over a length of at most 2√3, together
/// below 2⁻²²; and where a ray comes from [`FAR`], what moving its origin to the cube loses.
pub const PADDING: f32 = 1.0 / (1 << 21) as f32;

/// The relative rounding error of a slab test, twice over (Ize 2013): (1 + 2γ₃) rounded up.
const SLACK: f32 = 1.0 + 1.0 / (1 << 20) as f32;

/// No ray comes from farther away within the scene, in unit coordinates: moving its origin by so much loses 2⁻²³.
const FAR: f64 = (1u64 << 28) as f64;

/// The map from world to unit coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Space {
    centre: DVec3,
    /// A power of two, so that scaling a scene by one changes no bit here.
    scale: f64,
}

/// A ray in unit coordinates, from where it enters the unit cube.
#[derive(Clone, Copy, Debug)]
pub struct LocalRay {
    pub origin: [f32; 3],
    /// 1 / direction; never infinite.
    pub inverse: [f32; 3],
    /// 1 / direction, with the slack for the far side of a slab test.
    pub far_inverse: [f32; 3],
    /// For each axis 1 where the direction is negative: which of the two planes is met first.
    pub negative: [usize; 3],
    /// Boxes beyond this distance, in unit coordinates, are not visited.
    pub limit: f32,
    /// How far along the ray, in unit coordinates, the origin was moved.
    moved: f64,
}

impl Space {
    /// For what lies in a box, in a scene that extends as far as `scene` from its middle.
    pub fn new(bounds: Bounds, scene: f64) -> Self {
        let centre = 0.5 * bounds.0 + 0.5 * bounds.1;
        let extent = half_extent(bounds).max(scene / FAR);
        let exponent = if extent > 0.0 { ilogb(extent) + 1 } else { 0 };
        // Scenes at the very ends of the exponent range keep a finite scale.
        Self { centre, scale: scalbn(1.0, -exponent.clamp(-1000, 1000)) }
    }

    /// Length of the world's unit in unit coordinates.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// A point in unit coordinates.
    pub fn local(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }

    /// A box in unit coordinates, widened to hold all rounding.
    pub fn enclose(&self, lo: DVec3, hi: DVec3) -> ([f32; 3], [f32; 3]) {
        let (lo, hi) = (self.local(lo), self.local(hi));
        let down = |v: f64| (v as f32).next_down() - PADDING;
        let up = |v: f64| (v as f32).next_up() + PADDING;
        (lo.to_array().map(down), hi.to_array().map(up))
    }

    /// Clips the ray to the cube, without an end; `None` if it passes by.
    #[inline(always)]
    pub fn enter(&self, ray: &Ray) -> Option<LocalRay> {
        /// A direction this close to a plane of boxes does not cross the scene in that axis.
        const PARALLEL: f64 = 1.0 / (1u128 << 100) as f64;
        let origin = self.local(ray.origin);
        let direction = ray.direction.map(|d| if d.abs() < PARALLEL { PARALLEL.copysign(d) } else { d });
        let inverse = 1.0 / direction;
        let reach = 1.0 + 2.0 * PADDING as f64;
        let (a, b) = ((-reach - origin) * inverse, (reach - origin) * inverse);
        let entry = a.min(b).max_element().max(0.0);
        let exit = a.max(b).min_element();
        if entry > exit * (1.0 + 1.0 / (1u64 << 50) as f64) {
            return None;
        }
        let moved = if entry > 0.0 { origin + direction * entry } else { origin };
        Some(LocalRay {
            origin: moved.to_array().map(|v| v as f32),
            inverse: inverse.to_array().map(|v| v as f32),
            far_inverse: inverse.to_array().map(|v| v as f32 * SLACK),
            negative: direction.to_array().map(|d| usize::from(d.is_sign_negative())),
            limit: f32::INFINITY,
            moved: entry,
        })
    }
}

impl LocalRay {
    /// Ends the ray at the distance `t` (world).
    #[inline(always)]
    pub fn shorten(&mut self, space: &Space, t: f64) {
        self.limit = (t * space.scale - self.moved) as f32 * SLACK + PADDING;
    }
}
