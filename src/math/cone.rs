//! Cones of directions.

use super::function::{acos, cos, sin};
use super::{DVec3, Frame};
use crate::math::frame::unit;

/// Directions that differ from an axis by no more than an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Axis, of unit length.
    pub axis: DVec3,
    /// Cosine of the largest angle to the axis.
    pub cos: f64,
}

impl Cone {
    /// All directions.
    pub const EVERYWHERE: Self = Self { axis: DVec3::Z, cos: -1.0 };

    /// A single direction of unit length.
    pub fn along(axis: DVec3) -> Self {
        Self { axis, cos: 1.0 }
    }

    /// Around directions of unit length, about their mean; everywhere if there is none.
    pub fn around(directions: impl Iterator<Item = DVec3> + Clone) -> Self {
        let sum: DVec3 = directions.clone().sum();
        if sum.length_squared() == 0.0 {
            return Self::EVERYWHERE;
        }
        let axis = unit(sum);
        let cos = directions.map(|w| w.dot(axis)).fold(1.0, f64::min);
        Self { axis, cos: cos.max(-1.0) }
    }

    /// The smallest cone around two (Conty Estevez and Kulla 2018, Algorithm 1).
    pub fn union(a: Self, b: Self) -> Self {
        use std::f64::consts::PI;
        if a == Self::EVERYWHERE || b == Self::EVERYWHERE {
            return Self::EVERYWHERE;
        }
        if a.axis == b.axis {
            return if a.cos < b.cos { a } else { b };
        }
        let [half_a, half_b] = [a.cos, b.cos].map(acos);
        let between = acos(a.axis.dot(b.axis).clamp(-1.0, 1.0));
        if (between + half_b).min(PI) <= half_a {
            return a;
        }
        if (between + half_a).min(PI) <= half_b {
            return b;
        }
        let half = 0.5 * (half_a + between + half_b);
        let across = b.axis - a.axis * a.axis.dot(b.axis);
        if half >= PI {
            return Self::EVERYWHERE;
        }
        // With opposite axes, any side will do to turn to.
        let across = if across.length_squared() > 0.0 { unit(across) } else { Frame::about(a.axis).s };
        let turn = half - half_a;
        Self { axis: unit(a.axis * cos(turn) + across * sin(turn)), cos: cos(half) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::{direction, uniform};
    use rand_pcg::Pcg32;

    #[test]
    fn a_union_holds_both_and_touches_them() {
        let mut rng = Pcg32::new(0, 0);
        for _ in 0..10_000 {
            let mut cone = || Cone {
                axis: direction(&mut rng),
                cos: cos(uniform(&mut rng) * uniform(&mut rng) * std::f64::consts::PI),
            };
            let (a, b) = (cone(), cone());
            let both = Cone::union(a, b);
            let reach = |c: Cone| acos(c.axis.dot(both.axis).clamp(-1.0, 1.0)) + acos(c.cos);
            let half = acos(both.cos);
            for of in [a, b] {
                assert!(reach(of) <= half + 1e-7 || both == Cone::EVERYWHERE, "{a:?} {b:?} {both:?}");
            }
            let farthest = reach(a).max(reach(b));
            assert!((farthest - half).abs() < 1e-7 || both == Cone::EVERYWHERE, "{a:?} {b:?} {both:?}");
        }
    }

    #[test]
    fn a_cone_around_directions_holds_them() {
        let three = [DVec3::X, DVec3::Y, DVec3::Z];
        let cone = Cone::around(three.into_iter());
        assert!(three.iter().all(|w| w.dot(cone.axis) >= cone.cos));
        assert_eq!(Cone::around([DVec3::X, -DVec3::X].into_iter()), Cone::EVERYWHERE);
        assert_eq!(Cone::around(std::iter::empty()), Cone::EVERYWHERE);
    }
}
