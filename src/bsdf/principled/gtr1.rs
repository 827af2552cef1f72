//! The facets of a clear coat: Burley's "generalised Trowbridge–Reitz" law with exponent 1, whose tail is
//! longer than GGX's (Burley 2012, appendix B.2).

use crate::math::function::{exp, expm1, ln, sin_cos_turn};
use crate::math::{DVec2, DVec3};
use std::f64::consts::PI;

/// D(m) = (α² − 1) / (π ln α² (1 + (α² − 1) cos² θ)), with 0 < α < 1.
#[derive(Clone, Copy, Debug)]
pub struct Gtr1 {
    alpha2: f64,
    ln_alpha2: f64,
}

impl Gtr1 {
    pub fn new(alpha: f64) -> Self {
        Self { alpha2: alpha * alpha, ln_alpha2: ln(alpha * alpha) }
    }

    /// Facet area per macroscopic area and solid angle, in sr⁻¹; `m` is a unit vector, and with it the last
    /// factor is x² + y² + α²z².
    #[inline]
    pub fn density(&self, m: DVec3) -> f64 {
        (self.alpha2 - 1.0) / (PI * self.ln_alpha2 * (m.x * m.x + m.y * m.y + self.alpha2 * m.z * m.z))
    }

    /// The density, in sr⁻¹, with which [`Self::sample`] makes `m`.
    #[inline]
    pub fn pdf(&self, m: DVec3) -> f64 {
        self.density(m) * m.z
    }

    /// A facet normal, by its projected area.
    ///
    /// The area beyond the angle θ is ln(1 + (α² − 1) cos² θ) / ln α², so cos² θ = (1 − α^{2(1 − u)}) / (1 −
    /// α²) and sin² θ = α² (α^{−2u} − 1) / (1 − α²).
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let rest = 1.0 - self.alpha2;
        let sin2 = self.alpha2 * expm1(-self.ln_alpha2 * u.x) / rest;
        let cos2 = (1.0 - exp(self.ln_alpha2 * (1.0 - u.x))) / rest;
        let (sin_phi, cos_phi) = sin_cos_turn(u.y);
        let sin = sin2.max(0.0).sqrt();
        DVec3::new(sin * cos_phi, sin * sin_phi, cos2.max(0.0).sqrt())
    }
}
