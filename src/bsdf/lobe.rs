//! A lobe, as far as the choice of an emitter asks.

use super::mirror;
use crate::math::DVec3;

/// Largest [`Lobe::share`]. Where facets shadow one another the true lobe is another than this one, and an
/// emitter that is off it would be chosen almost never, with a huge weight, if nothing followed the cosine.
const LARGEST_SHARE: f64 = 0.95;

/// The directions in which a glossy surface reflects most.
///
/// For facets of the slopes of an ellipsoid (GGX) that reflect straight down, D(m)/4 is 1/(4πα²) ·
/// (α²/(α² + sin²(θ/2)))² nearly, θ being the angle between a direction and the mirror direction: the facet is
/// turned by half of it. The tails are those of no other lobe, but no lobe's are longer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// The mirror direction (unit).
    pub axis: DVec3,
    /// α², of the facets' roughness.
    pub alpha2: f64,
    /// The part of what is scattered that follows the lobe; the rest follows the cosine. Below 1.
    pub share: f64,
}

impl Lobe {
    /// All follows the cosine.
    pub const NONE: Self = Self { axis: DVec3::ZERO, alpha2: 1.0, share: 0.0 };

    /// Of facets of roughness α about the normal, seen from ω (local).
    #[inline]
    pub fn of_facets(wo: DVec3, alpha: f64, share: f64) -> Self {
        Self { axis: mirror(wo), alpha2: alpha * alpha, share: share.min(LARGEST_SHARE) }
    }

    /// How many times more light is scattered from a direction than by a matte surface that reflects as much
    /// in all, by the cosine of the angle to the axis. Over directions near by the mean is 1.
    #[inline]
    pub fn gain(&self, cos: f64) -> f64 {
        let turned = self.alpha2 + 0.5 * (1.0 - cos);
        (1.0 - self.share) + self.share * (0.25 * self.alpha2 / (turned * turned))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::integrate_from_kink;

    /// Over all directions, weighted by ω·axis as a matte surface would, for lobes that lie well above the
    /// surface.
    #[test]
    fn a_narrow_lobe_scatters_as_much_as_a_matte_surface() {
        for alpha in [0.01, 0.05, 0.1] {
            for share in [0.0, 0.5, 1.0] {
                let lobe = Lobe { axis: DVec3::Z, alpha2: alpha * alpha, share };
                // By the sine of half the angle.
                let ring = |h: f64| {
                    let cos = 1.0 - 2.0 * h * h;
                    lobe.gain(cos) * cos * 8.0 * h
                };
                let all = integrate_from_kink(0.0, std::f64::consts::FRAC_1_SQRT_2, ring);
                assert!((all - 1.0).abs() < 20.0 * alpha * alpha, "{alpha} {share}: {all}");
            }
        }
    }

    #[test]
    fn no_direction_is_left_out() {
        let mirrored = Lobe::of_facets(DVec3::new(0.6, 0.0, 0.8), 1e-4, 1.0);
        assert_eq!(mirrored.axis, DVec3::new(-0.6, 0.0, 0.8));
        assert!(mirrored.gain(-1.0) > 0.04 && mirrored.gain(1.0) > 1e6 && Lobe::NONE.gain(0.3) == 1.0);
    }
}
