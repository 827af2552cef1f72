//! Two lossless interfaces that scale radiance by η²: one of delta lobes, one diffuse on both sides.

use std::f64::consts::PI;

use super::cosine_weighted;
use crate::scatterer::{DVec3, Laws, Sample, Scatterer};

/// A smooth interface with a fixed reflectance, which suffices for the checks of delta lobes.
pub struct SmoothDielectric {
    pub eta: f64,
    pub reflectance: f64,
}

impl Scatterer for SmoothDielectric {
    fn value(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        if u[0] < self.reflectance {
            let wi = DVec3::new(-wo.x, -wo.y, wo.z);
            return Some(Sample { wi, weight: 1.0, pdf: self.reflectance, delta: true });
        }
        let weight = 1.0 / self.laws().flux_factor(wo, -wo);
        Some(Sample { wi: -wo, weight, pdf: 1.0 - self.reflectance, delta: true })
    }

    fn laws(&self) -> Laws {
        Laws { reciprocal: true, lossless: true, eta: Some(self.eta) }
    }
}

/// f = η(wo)² / (π (1 + η²)): reciprocal with η², lossless as flux, since ∫ η(wi)² |cos θi| dωi = π (1 + η²).
pub struct DiffuseDielectric {
    pub eta: f64,
}

impl DiffuseDielectric {
    fn share(&self, w: DVec3) -> f64 {
        let index = self.laws().index(w);
        index * index / (1.0 + self.eta * self.eta)
    }
}

impl Scatterer for DiffuseDielectric {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.share(wo) * wi.z.abs() / PI
    }

    fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
        self.share(wi) * wi.z.abs() / PI
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let side = if u[0] < self.share(DVec3::Z) { 1.0 } else { -1.0 };
        let wi = cosine_weighted([u[1], u[2]], side);
        Some(Sample { wi, weight: self.share(wo) / self.share(wi), pdf: self.pdf(wo, wi), delta: false })
    }

    fn laws(&self) -> Laws {
        Laws { reciprocal: true, lossless: true, eta: Some(self.eta) }
    }
}
