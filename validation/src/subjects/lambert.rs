//! The ideal diffuse reflector: f = albedo/π above the surface.

use std::f64::consts::FRAC_1_PI;

use super::cosine_weighted;
use crate::scatterer::{DVec3, Laws, Sample, Scatterer};

pub struct Lambert {
    pub albedo: f64,
}

impl Scatterer for Lambert {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.albedo * self.pdf(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 && wi.z > 0.0 { wi.z * FRAC_1_PI } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let wi = cosine_weighted([u[1], u[2]], 1.0);
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then_some(Sample { wi, weight: self.albedo, pdf, delta: false })
    }

    fn laws(&self) -> Laws {
        Laws { reciprocal: true, lossless: false, eta: None }
    }
}
