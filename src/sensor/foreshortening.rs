//! Areas on the film of a perspective camera.

use crate::math::{DVec2, DVec3, Transform};
use glam::DVec4;

/// How much of the film an area fills in front of a camera whose film is an image of half size `half` at
/// depth 1.
///
/// A place x of the film is seen along A d, d = (x, y, 1) less something that does not depend on x, so the
/// film's area dx fills the solid angle |det A| dx / |A d|³. With ω = A d / |A d| the third component of A⁻¹ω
/// is 1 / |A d|, and a point at depth z lies at the distance z |A d|. Together, dx/dA across the line of
/// sight is 1 / (|det A| (A⁻¹ω)₃ z²).
#[derive(Clone, Copy, Debug)]
pub struct Foreshortening {
    /// The third row of A⁻¹: depth from a point, and from a direction.
    depth: DVec4,
    /// 1 / (|det A| · area of the film).
    scale: f64,
}

impl Foreshortening {
    pub fn new(to_world: &Transform, half: DVec2) -> Self {
        let determinant = to_world.matrix.determinant().abs();
        Self { depth: to_world.inverse.row(2), scale: 1.0 / (4.0 * half.x * half.y * determinant) }
    }

    /// [`View::per_area`](super::View::per_area) at the point `p` along ω from the camera.
    #[inline]
    pub fn per_area(&self, w: DVec3, p: DVec3) -> f64 {
        let depth = self.depth.truncate().dot(p) + self.depth.w;
        self.scale / (self.depth.truncate().dot(w) * depth * depth)
    }
}
