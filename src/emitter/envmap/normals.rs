//! Some normals all over the sphere, on an octahedron unfolded to a square, for which choices are tabulated.

use crate::math::DVec3;
use crate::math::frame::unit;

/// Normals along an edge of the square that the octahedron is unfolded to; odd, so that the axes are among
/// them.
const NORMALS: usize = 17;

/// Most normals are nearer than this to the nearest of those, in radians.
pub const NEAR: f64 = 0.15;

/// The number, among those of normals, that stands for no normal: all directions are faced alike.
pub const ANYWHERE: usize = NORMALS * NORMALS;

/// The number of the normal nearest to n on the octahedron; [`ANYWHERE`] if n is zero.
#[inline]
pub fn nearest(n: DVec3) -> usize {
    if n == DVec3::ZERO {
        return ANYWHERE;
    }
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let (a, b) = if n.y < 0.0 { (fold(n.x, n.z), fold(n.z, n.x)) } else { (n.x, n.z) };
    let [column, row] = [a, b].map(|v| ((0.5 + 0.5 * v) * (NORMALS - 1) as f64 + 0.5) as usize);
    row * NORMALS + column
}

/// The normal (unit) of a number below [`ANYWHERE`].
pub fn normal_of(number: usize) -> DVec3 {
    let [a, b] = [number % NORMALS, number / NORMALS].map(|i| 2.0 * i as f64 / (NORMALS - 1) as f64 - 1.0);
    let y = 1.0 - a.abs() - b.abs();
    let (x, z) = if y < 0.0 { (fold(a, b), fold(b, a)) } else { (a, b) };
    unit(DVec3::new(x, y, z))
}

/// A coordinate of the octahedron's lower half in the unfolded square, and back.
#[inline]
fn fold(a: f64, b: f64) -> f64 {
    (1.0 - b.abs()).copysign(a)
}

#[cfg(test)]
pub mod tests {
    use super::super::directions::direction;
    use super::*;

    /// Directions evenly all over the sphere.
    pub fn even(count: usize) -> impl Iterator<Item = DVec3> {
        (0..count).map(move |i| {
            direction((i as f64 * 0.618_033_988_749_895) % 1.0, 1.0 - (2.0 * i as f64 + 1.0) / count as f64)
        })
    }

    #[test]
    fn the_nearest_normal_is_near() {
        let near = even(100_000).filter(|n| libm::acos(n.dot(normal_of(nearest(*n)))) < NEAR).count();
        assert!((80_000..100_000).contains(&near), "{near}");
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            assert_eq!((normal_of(nearest(axis)), normal_of(nearest(-axis))), (axis, -axis));
        }
    }
}
