//! A correct model with one fault.

use crate::scatterer::{DVec3, Laws, Sample, Scatterer};

/// The fault.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// The density is 2 % too large everywhere, and weights follow it.
    PdfScaled,
    /// The value lacks |cos θi|, and weights follow it.
    NoCosine,
    /// Weights are 0.1 % too large; value and density are right.
    WeightScaled,
    /// Sampled directions end up below the surface.
    HemisphereMirrored,
    /// Sampled directions are mirrored at the yz plane.
    AzimuthMirrored,
    /// Sampled directions are turned by 0.02 rad around the normal.
    Turned,
    /// The value has the factor 1 + 0.01 wi.x, and weights follow it.
    OneWay,
    /// The value ignores η² on crossing, and weights follow it.
    NoRadianceScaling,
    /// The density is NaN at grazing angles below 10⁻⁸.
    GrazingNan,
    /// Everything is 3 % too bright, consistently.
    TooBright,
    /// One draw in a hundred is lost although the density promises it.
    DrawsLost,
    /// The value is 1 % larger than the one that weights follow.
    ValueScaled,
    /// The density has the factor 1 + 10⁻⁵ wi.x, and weights follow it.
    PdfTilted,
    /// Weights have the factor 1 + 0.02 wi.x; value and density are right.
    WeightTilted,
    /// Samples of a lobe that is spread are said to be of a delta lobe, outside which there is nothing.
    SpreadDelta,
    /// Delta lobes are drawn 2 % more often than their pdf says.
    UnlikelyDelta,
    /// Delta lobes that lead down are 1 % too bright.
    OneWayDelta,
}

pub struct Sabotaged<'a> {
    pub honest: &'a dyn Scatterer,
    pub fault: Fault,
}

impl Scatterer for Sabotaged<'_> {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        let value = self.honest.value(wo, wi);
        match self.fault {
            Fault::NoCosine => value / wi.z.abs(),
            Fault::OneWay => value * (1.0 + 0.01 * wi.x),
            Fault::NoRadianceScaling => value * self.laws().flux_factor(wo, wi),
            Fault::TooBright => 1.03 * value,
            Fault::ValueScaled => 1.01 * value,
            Fault::SpreadDelta => 0.0,
            _ => value,
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let pdf = self.honest.pdf(wo, wi);
        match self.fault {
            Fault::PdfScaled => 1.02 * pdf,
            Fault::PdfTilted => pdf * (1.0 + 1e-5 * wi.x),
            Fault::GrazingNan if wi.z.abs() < 1e-8 => f64::NAN,
            Fault::SpreadDelta => 0.0,
            _ => pdf,
        }
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let honest = self.honest.sample(wo, u)?;
        let mut sample = honest;
        match self.fault {
            Fault::HemisphereMirrored => sample.wi.z = -honest.wi.z,
            Fault::AzimuthMirrored => sample.wi.x = -honest.wi.x,
            Fault::Turned => sample.wi = glam::DQuat::from_rotation_z(0.02) * honest.wi,
            Fault::WeightScaled => sample.weight *= 1.001,
            Fault::WeightTilted => sample.weight *= 1.0 + 0.02 * honest.wi.x,
            Fault::ValueScaled => return Some(honest),
            Fault::DrawsLost if u[0] < 0.01 => return None,
            Fault::DrawsLost => return Some(honest),
            Fault::SpreadDelta => (sample.pdf, sample.delta) = (1.0, true),
            Fault::UnlikelyDelta => sample.pdf *= 0.98,
            Fault::OneWayDelta if honest.wi.z < 0.0 && wo.z > 0.0 => sample.weight *= 1.01,
            Fault::OneWayDelta => return Some(honest),
            _ => {
                sample.pdf = self.pdf(wo, honest.wi);
                sample.weight = self.value(wo, honest.wi) / sample.pdf;
            }
        }
        Some(sample)
    }

    fn laws(&self) -> Laws {
        self.honest.laws()
    }
}
