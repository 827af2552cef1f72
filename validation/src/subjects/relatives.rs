//! Models with a limit, and models with companions at other wavelengths.

use super::Lambert;
use crate::scatterer::{DVec3, Laws, Limit, Sample, Scatterer};

/// A model that claims to be near its limit.
pub struct Near<'a> {
    pub model: &'a dyn Scatterer,
    pub limit: &'a dyn Scatterer,
    /// Largest difference of a flux moment from that of `limit`.
    pub within: f64,
}

impl Scatterer for Near<'_> {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.model.value(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.model.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        self.model.sample(wo, u)
    }

    fn laws(&self) -> Laws {
        self.model.laws()
    }

    fn limit(&self) -> Option<Limit<'_>> {
        Some(Limit { scatterer: self.limit, within: self.within })
    }
}

/// A diffuse reflector whose albedo increases with the wavelength, on a path that carries another wavelength.
pub struct Coloured {
    /// Wavelength in nm.
    pub nm: f64,
    /// The path's other wavelength in nm.
    pub beside: f64,
    /// Share of the albedo that is taken at the other wavelength, in the value and in the weights of samples:
    /// the fault.
    pub leak: [f64; 2],
}

impl Coloured {
    fn lambert(&self, leak: f64) -> Lambert {
        Lambert { albedo: ((1.0 - leak) * self.nm + leak * self.beside) / 1000.0 }
    }
}

impl Scatterer for Coloured {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.lambert(self.leak[0]).value(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.lambert(0.0).pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        self.lambert(self.leak[1]).sample(wo, u)
    }

    fn companions(&self) -> Vec<Box<dyn Scatterer + '_>> {
        let other = |beside: f64| Box::new(Coloured { beside, ..*self }) as Box<dyn Scatterer>;
        vec![other(450.0), other(650.0)]
    }
}
