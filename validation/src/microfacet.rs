//! The albedo of a rough surface under single scattering, from the definitions (Walter et al. 2007): the loss
//! to expect of models that ignore light between facets. Implemented independently of any renderer; masking
//! is separable.

use std::f64::consts::PI;

use crate::{
    quadrature::{Cell, Integral, integrate},
    scatterer::DVec3,
};

/// The distribution of the facets' slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slopes {
    /// Gaussian slopes, with the masking function in the rational fit of Walter et al. (equation 27).
    Beckmann,
    /// GGX: the slopes of an ellipsoid.
    Ggx,
}

/// A rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    pub slopes: Slopes,
    /// Roughness.
    pub alpha: f64,
    /// Index of refraction behind the surface over that in front; `None` for facets that are perfect mirrors.
    pub eta: Option<f64>,
}

/// Cells along each axis that quadrature starts from.
const CELLS: f64 = 16.0;

impl Rough {
    /// The flux that leaves over the flux that arrives, for light from a direction with cosine `cosine` to
    /// the normal, with an error below `tolerance` where the budget of evaluations allows.
    ///
    /// ∫ D(m) G₁(o, m) (o·m)/(o·n) [F G₁(r) + (1 − F) G₁(t)] dm, in the coordinates in which D(m)(m·n) dm is
    /// uniform.
    pub fn albedo(&self, cosine: f64, tolerance: f64) -> Integral {
        let o = DVec3::new(((1.0 - cosine) * (1.0 + cosine)).sqrt(), 0.0, cosine);
        // The distribution is symmetric about the plane of incidence. Many cells, so that edges do not fall
        // between the first quadrature points.
        let strip = |i: usize, j: usize| Cell {
            low: [i as f64 / CELLS, PI * j as f64 / CELLS],
            high: [(i + 1) as f64 / CELLS, PI * (j + 1) as f64 / CELLS],
        };
        let cells: Vec<Cell> = (0..256).map(|k| strip(k / 16, k % 16)).collect();
        let found = integrate(&cells, tolerance * PI, 4_000_000, |[s, phi]| {
            if s == 0.0 {
                return 0.0;
            }
            // v = 1 − s² is uniform; the substitution removes the pole of 1/(m·n) at grazing facets.
            let slope = match self.slopes {
                Slopes::Beckmann => (-2.0 * libm::log(s)).sqrt(),
                Slopes::Ggx => ((1.0 - s) * (1.0 + s)).sqrt() / s,
            } * self.alpha;
            let m = DVec3::new(slope * libm::cos(phi), slope * libm::sin(phi), 1.0).normalize();
            let facing = o.dot(m);
            if facing <= 0.0 {
                0.0
            } else {
                2.0 * s * facing / (o.z * m.z) * self.masking(o) * self.leaving(o, m, facing)
            }
        });
        Integral { value: found.value / PI, error: found.error / PI }
    }

    /// The share of the light meeting a facet that leaves without meeting another.
    fn leaving(&self, o: DVec3, m: DVec3, facing: f64) -> f64 {
        let reflected = 2.0 * facing * m - o;
        let escapes = |w: DVec3, side: f64| if w.z * side > 0.0 { self.masking(w) } else { 0.0 };
        let Some(eta) = self.eta else { return escapes(reflected, 1.0) };
        let below = 1.0 - (1.0 - facing * facing) / (eta * eta);
        if below <= 0.0 {
            return escapes(reflected, 1.0);
        }
        let cosine = below.sqrt();
        let (s, p) = (
            (facing - eta * cosine) / (facing + eta * cosine),
            (eta * facing - cosine) / (eta * facing + cosine),
        );
        let fresnel = 0.5 * (s * s + p * p);
        let refracted = (facing / eta - cosine) * m - o / eta;
        fresnel * escapes(reflected, 1.0) + (1.0 - fresnel) * escapes(refracted, -1.0)
    }

    /// Smith's G₁ of a direction on either side.
    fn masking(&self, w: DVec3) -> f64 {
        let tangent = self.alpha * (w.x * w.x + w.y * w.y).sqrt() / w.z.abs();
        match self.slopes {
            Slopes::Ggx => 2.0 / (1.0 + (1.0 + tangent * tangent).sqrt()),
            Slopes::Beckmann => {
                let a = 1.0 / tangent;
                if a >= 1.6 { 1.0 } else { (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_surfaces_lose_nothing_and_rough_ones_more_the_rougher() {
        for slopes in [Slopes::Beckmann, Slopes::Ggx] {
            for eta in [None, Some(1.5), Some(1.0 / 1.5)] {
                let albedo = |alpha: f64| Rough { slopes, alpha, eta }.albedo(0.7, 1e-5).value;
                assert!((albedo(1e-3) - 1.0).abs() < 1e-3, "{slopes:?} {eta:?} {}", albedo(1e-3));
                assert!(albedo(0.3) > albedo(0.6) && albedo(0.6) > albedo(1.0) && albedo(0.3) < 1.0);
            }
        }
    }

    /// At normal incidence the GGX mirror's albedo is ∫ G₁(r) dv over facets whose reflection leaves upward,
    /// θr = 2θm, a one-dimensional integral.
    #[test]
    fn a_mirror_seen_from_above_is_a_simple_integral() {
        let alpha = 0.5f64;
        let steps = 1_000_000;
        let sum: f64 = (0..steps)
            .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
            .map(|v| {
                let cosine = 1.0 / (1.0 + alpha * alpha * v / (1.0 - v)).sqrt();
                let up = 2.0 * cosine * cosine - 1.0;
                let tangent = if up > 0.0 { alpha * (1.0 - up * up).sqrt() / up } else { f64::INFINITY };
                2.0 / (1.0 + (1.0 + tangent * tangent).sqrt())
            })
            .sum();
        let found = Rough { slopes: Slopes::Ggx, alpha, eta: None }.albedo(1.0, 1e-7).value;
        assert!((found - sum / f64::from(steps)).abs() < 1e-6, "{found}");
    }
}
