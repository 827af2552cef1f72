//! A rough conductor: GGX normals (Walter et al. 2007) with separable masking, visible normals sampled (Heitz
//! 2018), and Schlick's Fresnel term.

use std::f64::consts::{PI, TAU};

use crate::scatterer::{DVec3, Laws, Sample, Scatterer};

pub struct Conductor {
    pub alpha: f64,
    /// Reflectance at normal incidence.
    pub r0: f64,
}

impl Conductor {
    /// D(m), with the denominator (cos²θ + sin²θ/α²) written without cancellation near the pole.
    fn density(&self, m: DVec3) -> f64 {
        let tangent = (m.x * m.x + m.y * m.y) / (self.alpha * self.alpha);
        let root = self.alpha * (m.z * m.z + tangent);
        1.0 / (PI * root * root)
    }

    /// Smith's G₁ = 2 cos / (cos + √(cos² + α² sin²)).
    fn unmasked(&self, w: DVec3) -> f64 {
        let sine_squared = w.x * w.x + w.y * w.y;
        2.0 * w.z / (w.z + (w.z * w.z + self.alpha * self.alpha * sine_squared).sqrt())
    }

    fn fresnel(&self, cosine: f64) -> f64 {
        let x = (1.0 - cosine).max(0.0);
        self.r0 + (1.0 - self.r0) * x * x * x * x * x
    }

    fn visible_normal(&self, wo: DVec3, u: [f64; 2]) -> DVec3 {
        let stretched = DVec3::new(self.alpha * wo.x, self.alpha * wo.y, wo.z).normalize();
        let across = DVec3::new(-stretched.y, stretched.x, 0.0).try_normalize().unwrap_or(DVec3::X);
        let up = stretched.cross(across);
        let (radius, phi) = (u[0].sqrt(), TAU * u[1]);
        let x = radius * libm::cos(phi);
        let share = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - share) * (1.0 - x * x).max(0.0).sqrt() + share * radius * libm::sin(phi);
        let normal = x * across + y * up + (1.0 - x * x - y * y).max(0.0).sqrt() * stretched;
        DVec3::new(self.alpha * normal.x, self.alpha * normal.y, normal.z.max(0.0)).normalize()
    }
}

impl Scatterer for Conductor {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        let pdf = self.pdf(wo, wi);
        if pdf > 0.0 { pdf * self.unmasked(wi) * self.fresnel(wo.dot((wo + wi).normalize())) } else { 0.0 }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        self.unmasked(wo) * self.density((wo + wi).normalize()) / (4.0 * wo.z)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        if wo.z <= 0.0 {
            return None;
        }
        let m = self.visible_normal(wo, [u[1], u[2]]);
        let wi = (2.0 * wo.dot(m) * m - wo).normalize();
        let pdf = self.pdf(wo, wi);
        let weight = self.unmasked(wi) * self.fresnel(wo.dot((wo + wi).normalize()));
        (pdf > 0.0).then_some(Sample { wi, weight, pdf, delta: false })
    }

    fn laws(&self) -> Laws {
        Laws { reciprocal: true, lossless: false, eta: None }
    }
}
