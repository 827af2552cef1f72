//! Rough interfaces as flat facets with distributed normals (Walter et al. 2007, "Microfacet Models for
//! Refraction through Rough Surfaces"), with Smith's masking, separately for the two directions as in
//! Mitsuba.
//!
//! Densities are written in x² + y² of the facet normal, never in 1 − z², so that α = 1e-4 keeps its digits.

use super::slope::{SQRT_PI, gaussian, visible_gaussian};
use crate::math::frame::unit;
use crate::math::function::{exp, ln, sin_cos_turn};
use crate::math::gaussian::erfcx;
use crate::math::{DVec2, DVec3};
use std::f64::consts::PI;

/// The distribution of the facets' slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Gaussian slopes.
    Beckmann,
    /// The slopes of an ellipsoid (Trowbridge and Reitz 1975).
    Ggx,
}

/// A distribution of facet normals about +z, and how it is sampled.
#[derive(Clone, Copy, Debug)]
pub struct Distribution {
    shape: Shape,
    /// Roughness along x and y: for Beckmann √2 times the standard deviation of the slope.
    alpha_u: f64,
    alpha_v: f64,
    /// Whether only normals that the viewer sees are sampled.
    visible: bool,
}

impl Distribution {
    /// With visible normals sampled. Roughness below 1e-4 counts as 1e-4, as in Mitsuba.
    pub fn new(shape: Shape, alpha_u: f64, alpha_v: f64) -> Self {
        Self { shape, alpha_u: alpha_u.max(1e-4), alpha_v: alpha_v.max(1e-4), visible: true }
    }

    /// The same, with visible normals sampled or all, as Mitsuba's `sample_visible` says.
    pub fn sampling_visible(self, visible: bool) -> Self {
        Self { visible, ..self }
    }

    /// Roughness in the rougher direction.
    #[inline]
    pub fn alpha(&self) -> f64 {
        self.alpha_u.max(self.alpha_v)
    }

    /// The distribution to sample for a viewer at `cos`: without visible normals Walter et al. (section 5.3)
    /// widen it towards grazing directions, which bounds the weights.
    #[inline]
    pub fn widened(self, cos: f64) -> Self {
        let factor = if self.visible { 1.0 } else { 1.2 - 0.2 * cos.sqrt() };
        Self { alpha_u: self.alpha_u * factor, alpha_v: self.alpha_v * factor, ..self }
    }

    /// D(m) in sr⁻¹: facet area per macroscopic area and solid angle, so that ∫D(m) cos θ dm = 1.
    #[inline]
    pub fn density(&self, m: DVec3) -> f64 {
        let (x, y, z2) = (m.x / self.alpha_u, m.y / self.alpha_v, m.z * m.z);
        let r2 = x * x + y * y;
        let scale = 1.0 / (PI * self.alpha_u * self.alpha_v);
        match self.shape {
            // The limit of facets that stand upright.
            Shape::Beckmann if z2 * z2 == 0.0 => 0.0,
            Shape::Beckmann => scale * exp(-r2 / z2) / (z2 * z2),
            Shape::Ggx => scale / ((r2 + z2) * (r2 + z2)),
        }
    }

    /// Smith's G₁: the share of the facets facing `v` that no other hides; 0 where `m` faces away.
    ///
    /// For Beckmann the rational fit by Walter et al. (equation 27, within 0.35 %), because Mitsuba's image
    /// has it.
    #[inline]
    pub fn masking(&self, v: DVec3, m: DVec3) -> f64 {
        if v.dot(m) * v.z <= 0.0 {
            return 0.0;
        }
        let slope = self.stretched_slope(v);
        match self.shape {
            Shape::Ggx => 2.0 / (1.0 + (1.0 + slope * slope).sqrt()),
            Shape::Beckmann if slope * 1.6 <= 1.0 => 1.0,
            // The fit with numerator and denominator times slope².
            Shape::Beckmann => (3.535 * slope + 2.181) / (slope * slope + 2.276 * slope + 2.577),
        }
    }

    /// G₁ without a fit: the integral that normalises the density of visible normals.
    #[inline]
    fn visible_share(&self, w: DVec3) -> f64 {
        let slope = self.stretched_slope(w);
        match self.shape {
            Shape::Ggx => 2.0 / (1.0 + (1.0 + slope * slope).sqrt()),
            // Λ = (exp(−a²)/(a√π) − erfc a)/2 with a = 1/slope is below rounding from a = 6 on.
            Shape::Beckmann if slope * 6.0 <= 1.0 => 1.0,
            Shape::Beckmann => {
                let a = 1.0 / slope;
                2.0 / (2.0 + exp(-a * a) * (slope / SQRT_PI - erfcx(a)))
            }
        }
    }

    /// α tan θ of a direction, α being the roughness along it.
    #[inline]
    fn stretched_slope(&self, v: DVec3) -> f64 {
        let (x, y) = (self.alpha_u * v.x, self.alpha_v * v.y);
        (x * x + y * y).sqrt() / v.z.abs()
    }

    /// The density, in sr⁻¹, with which [`Self::sample`] makes `m` for a viewer `w` with w.z > 0.
    #[inline]
    pub fn pdf(&self, w: DVec3, m: DVec3) -> f64 {
        self.density(m) * self.drawn_share(w, m)
    }

    /// Ratio of the density of sampled facets to that of facets.
    #[inline]
    fn drawn_share(&self, w: DVec3, m: DVec3) -> f64 {
        if self.visible { self.visible_share(w) * w.dot(m).max(0.0) / w.z } else { m.z }
    }

    /// D·G of directions that meet at a facet `m`, and the density with which a viewer `wo` samples it.
    #[inline]
    pub fn shown_and_drawn(&self, wo: DVec3, wi: DVec3, m: DVec3) -> (f64, f64) {
        let density = self.density(m);
        (density * self.masking(wo, m) * self.masking(wi, m), density * self.drawn_share(wo, m))
    }

    /// The same if the viewer samples the [widened](Self::widened) distribution.
    #[inline]
    pub fn shown_and_drawn_widened(&self, wo: DVec3, wi: DVec3, m: DVec3) -> (f64, f64) {
        let (shown, drawn) = self.shown_and_drawn(wo, wi, m);
        (shown, if self.visible { drawn } else { self.widened(wo.z).pdf(wo, m) })
    }

    /// Draws a facet normal for a viewer `w` with w.z > 0.
    #[inline]
    pub fn sample(&self, w: DVec3, u: DVec2) -> DVec3 {
        // Stretching the surface to roughness 1 turns `w` along and keeps visibility.
        let stretched = || unit(DVec3::new(self.alpha_u * w.x, self.alpha_v * w.y, w.z));
        let slope = match self.shape {
            _ if !self.visible => self.any_slope(u),
            Shape::Beckmann => visible_beckmann(stretched(), u),
            Shape::Ggx => return self.shrink(visible_ggx(stretched(), u)),
        };
        self.shrink(DVec3::new(-slope.x, -slope.y, 1.0))
    }

    /// A slope at roughness 1 with probability proportional to the facets' projected area: D(m) cos θ.
    fn any_slope(&self, u: DVec2) -> DVec2 {
        let r = match self.shape {
            Shape::Beckmann => (-ln(1.0 - u.x)).sqrt(),
            Shape::Ggx => (u.x / (1.0 - u.x)).sqrt(),
        };
        let (sin, cos) = sin_cos_turn(u.y);
        DVec2::new(r * cos, r * sin)
    }

    /// The normal at this roughness that corresponds to a normal at roughness 1.
    #[inline]
    fn shrink(&self, h: DVec3) -> DVec3 {
        unit(DVec3::new(self.alpha_u * h.x, self.alpha_v * h.y, h.z))
    }

    /// D·G/(4 cos θ) for reflection at `m` half-way between `wo` and `wi`, both above the surface, and the
    /// density of `wi` when `m` is sampled. The value still lacks its Fresnel factor.
    #[inline]
    pub fn reflection(&self, wo: DVec3, wi: DVec3, m: DVec3) -> (f64, f64) {
        let cos = wo.dot(m);
        // Along the surface, half-way between opposite directions, m is left to rounding.
        if cos <= 0.0 {
            return (0.0, 0.0);
        }
        let (shown, drawn) = self.shown_and_drawn(wo, wi, m);
        (shown / (4.0 * wo.z), drawn / (4.0 * cos))
    }
}

/// The slope that a unit `w` sees at roughness 1: along its azimuth the visible law, across it the plain one.
fn visible_beckmann(w: DVec3, u: DVec2) -> DVec2 {
    let sin = (w.x * w.x + w.y * w.y).sqrt();
    let (s, t) = if sin > 0.0 { (w.x / sin, w.y / sin) } else { (1.0, 0.0) };
    let (x, y) = (visible_gaussian(w.z, sin, u.x), gaussian(u.y));
    DVec2::new(s * x - t * y, t * x + s * y)
}

/// A normal (not unit) that a unit `w` sees on the hemisphere, GGX at roughness 1: the half vector of `w` and
/// a uniform direction of the cap z > −w.z (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with
/// Spherical Caps").
fn visible_ggx(w: DVec3, u: DVec2) -> DVec3 {
    let (sin, cos) = sin_cos_turn(u.y);
    // 1 − z and z + w.z of the cap direction, each without cancellation.
    let (below, above) = (u.x * (1.0 + w.z), (1.0 - u.x) * (1.0 + w.z));
    let r = (below * (2.0 - below)).max(0.0).sqrt();
    DVec3::new(r * cos + w.x, r * sin + w.y, above)
}

/// A reflected direction: `w` mirrored at a facet `m`.
#[inline]
pub fn reflect(w: DVec3, m: DVec3) -> DVec3 {
    m * (2.0 * w.dot(m)) - w
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distributions() -> impl Iterator<Item = Distribution> {
        let shapes = [Shape::Beckmann, Shape::Ggx].into_iter();
        shapes.flat_map(|shape| {
            [(0.1, 0.1), (0.3, 0.7), (1e-4, 1e-4), (1e-4, 0.5)].into_iter().flat_map(move |(u, v)| {
                [true, false].map(|visible| Distribution::new(shape, u, v).sampling_visible(visible))
            })
        })
    }

    /// pdf·|∂m/∂u| = 1, the Jacobian by central differences in the slopes, which are exact at any roughness.
    #[test]
    fn density_times_jacobian_is_one() {
        const H: f64 = 1e-5;
        for facets in distributions() {
            for w in [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (-0.3, 0.8, 0.1), (0.5, 0.7, 1e-3)] {
                let w = unit(DVec3::new(w.0, w.1, w.2));
                for i in 0..100 {
                    let u = DVec2::new((i / 10) as f64 / 10.0 + 0.0512, (i % 10) as f64 / 10.0 + 0.0487);
                    let slope = |u: DVec2| {
                        let m = facets.sample(w, u);
                        DVec2::new(m.x / m.z, m.y / m.z)
                    };
                    let du = (slope(u + DVec2::X * H) - slope(u - DVec2::X * H)) / (2.0 * H);
                    let dv = (slope(u + DVec2::Y * H) - slope(u - DVec2::Y * H)) / (2.0 * H);
                    let m = facets.sample(w, u);
                    // Solid angle is slope area times cos³.
                    let one = facets.pdf(w, m) * du.perp_dot(dv).abs() * m.z * m.z * m.z;
                    assert!((one - 1.0).abs() < 1e-4, "{facets:?} {w} {u}: {one}");
                }
            }
        }
    }

    #[test]
    fn facets_that_stand_upright_have_a_density() {
        for facets in distributions() {
            for z in [0.0, 1e-300, 1e-100, 1e-30] {
                let density = facets.density(DVec3::new(0.6, 0.8, z));
                assert!(
                    density.is_finite() && (density == 0.0 || facets.shape == Shape::Ggx),
                    "{facets:?} {z}"
                );
            }
        }
    }

    #[test]
    fn masking_is_its_fit_and_the_fit_is_near() {
        for facets in distributions() {
            for i in 1..=1000 {
                let z = i as f64 / 1000.0;
                let w = DVec3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z);
                let ratio = facets.masking(w, w) / facets.visible_share(w);
                assert!((ratio - 1.0).abs() < 3.6e-3, "{facets:?} {z} {ratio}");
                assert_eq!(facets.masking(w, -w), 0.0);
            }
        }
    }
}
