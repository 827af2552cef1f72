//! Orthonormal bases.

use glam::DVec3;

/// A right-handed orthonormal basis; local directions have the normal as their third coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub s: DVec3,
    pub t: DVec3,
    pub n: DVec3,
}

impl Frame {
    /// Any frame about the unit vector `n`, without branches or cancellation (Duff et al. 2017, listing 3).
    #[inline]
    pub fn about(n: DVec3) -> Self {
        let sign = 1f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            s: DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: DVec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// The frame about `n` whose `s` lies in the plane of `n` and `tangent`, for surfaces with a preferred
    /// direction. Falls back to [`Frame::about`] where the tangent is parallel to `n` or vanishes.
    pub fn along(n: DVec3, tangent: DVec3) -> Self {
        let s = tangent - n * n.dot(tangent);
        let size = length(s);
        if size > 0.0 && size.is_finite() {
            let s = s / size;
            Self { s, t: n.cross(s), n }
        } else {
            Self::about(n)
        }
    }

    /// World to local.
    #[inline]
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world.
    #[inline]
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

/// |v|. glam's own `length` takes the root by an SSE instruction of the `libm` crate, at which the processor
/// waits for its AVX registers: it cost a sixth of a whole render.
#[inline(always)]
pub fn length(v: DVec3) -> f64 {
    v.dot(v).sqrt()
}

/// `v` / |v|. glam's own `normalize` multiplies by a reciprocal, which costs half a digit.
#[inline]
pub fn unit(v: DVec3) -> DVec3 {
    v / length(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for i in 0..1000 {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / 1000.0;
            let (sin, cos) = crate::math::function::sincos(i as f64);
            let r = (1.0 - z * z).sqrt();
            let n = unit(DVec3::new(r * cos, r * sin, z));
            for frame in [Frame::about(n), Frame::along(n, DVec3::new(0.3, -0.2, 0.9))] {
                assert!(length(frame.s.cross(frame.t) - n) < 1e-14);
                assert!((length(frame.s) - 1.0).abs() < 1e-14 && frame.s.dot(frame.t).abs() < 1e-14);
            }
        }
        for n in [DVec3::Z, -DVec3::Z] {
            assert!(length(Frame::about(n).s.cross(Frame::about(n).t) - n) < 1e-15);
        }
    }
}
