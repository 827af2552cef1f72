//! A mixture of overlapping lobes, in whose density one is easily forgotten.

use super::{Conductor, Lambert};
use crate::scatterer::{DVec3, Laws, Sample, Scatterer};

/// A conductor in the share `share` of the draws, else a diffuse reflector.
pub struct Mixture {
    pub conductor: Conductor,
    pub lambert: Lambert,
    pub share: f64,
    /// Whether the stated density leaves out the diffuse lobe, as a fault.
    pub forgetful: bool,
}

impl Mixture {
    fn mean(&self, of: impl Fn(&dyn Scatterer) -> f64) -> f64 {
        self.share * of(&self.conductor) + (1.0 - self.share) * of(&self.lambert)
    }
}

impl Scatterer for Mixture {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.mean(|part| part.value(wo, wi))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if self.forgetful {
            self.share * self.conductor.pdf(wo, wi)
        } else {
            self.mean(|part| part.pdf(wo, wi))
        }
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let part: &dyn Scatterer = if u[0] < self.share { &self.conductor } else { &self.lambert };
        let wi = part.sample(wo, u)?.wi;
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| Sample { wi, weight: self.value(wo, wi) / pdf, pdf, delta: false })
    }

    fn laws(&self) -> Laws {
        Laws { reciprocal: true, lossless: false, eta: None }
    }
}
