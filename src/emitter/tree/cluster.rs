//! Bounds of some emitters together.

use crate::math::DVec3;
use crate::math::bounds::{Bounds, union};
use crate::math::cone::Cone;
use crate::math::function::{acos, cos, sin};

/// Bounds of emitters in space and direction, and how much they emit.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    pub bounds: Bounds,
    /// Cone around all normals (world).
    pub normals: Cone,
    /// Cosine of the largest angle with a normal at which light leaves.
    pub cos_beyond: f64,
    /// The sum of what each emits in the direction in which it emits most, per solid angle.
    pub intensity: f64,
}

impl Cluster {
    /// Bounds of both.
    pub fn union(a: Self, b: Self) -> Self {
        Self {
            bounds: union(a.bounds, b.bounds),
            normals: Cone::union(a.normals, b.normals),
            cos_beyond: a.cos_beyond.min(b.cos_beyond),
            intensity: a.intensity + b.intensity,
        }
    }

    /// The middle of the box, and the squared radius of the ball about it.
    pub fn ball(&self) -> (DVec3, f64) {
        let (lo, hi) = self.bounds;
        (0.5 * lo + 0.5 * hi, (0.5 * hi - 0.5 * lo).length_squared())
    }

    /// Cost of a node of the tree: its intensity, times its extent, times the solid angle into which it emits,
    /// weighted by the cosine beyond the normals (Conty Estevez and Kulla 2018, §4.1). The extent is the
    /// squared diagonal of the box, not its surface, which is zero for emitters in a row.
    pub fn cost(&self) -> f64 {
        use std::f64::consts::{FRAC_PI_2, PI, TAU};
        let (lo, hi) = self.bounds;
        let extent = self.intensity * (hi - lo).length_squared();
        if self.normals == Cone::EVERYWHERE {
            return 2.0 * TAU * extent;
        }
        let normals = acos(self.normals.cos);
        let reach = (normals + acos(self.cos_beyond)).min(PI);
        let beyond = 2.0 * reach * sin(normals) - cos(normals - 2.0 * reach) - 2.0 * normals * sin(normals)
            + cos(normals);
        extent * (TAU * (1.0 - self.normals.cos) + FRAC_PI_2 * beyond)
    }
}
