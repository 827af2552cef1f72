//! The contributions that receivers get of a source's light.

use super::rivals::{Contested, Rivals};
use crate::integrator::CameraPath;
use crate::spectrum::Spectrum;
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

/// What a receiver gets of the light of a source, not yet divided by the sum of densities. Geometry
/// and density are multiplied with π, which cancels.
#[derive(Clone, Copy)]
pub struct Contribution {
    /// Throughput from the source to the camera, without the geometry term.
    pub weight: Spectrum,
    /// Geometry term, apart from `weight`, whose numbers might not hold its range.
    pub geometry: f64,
    /// Density, by area, with which the receiver's own path would have come to the source, times that of its
    /// next direction if the source is rough.
    pub density: f64,
}

impl Contribution {
    /// Of a matte source to a matte receiver.
    pub fn matte(weight: Spectrum, geometry: f64) -> Self {
        Self { weight, geometry, density: geometry }
    }
}

/// Light that leaves a source.
#[derive(Clone, Debug)]
pub enum Light {
    /// From a camera path: the light that nothing else finds, and its range of the [`Contested`] light.
    ByCamera(Spectrum, Range<usize>),
    /// From a light path: the light, and a scale of which a lane might not hold the range.
    ByLight(Spectrum, f64, Rivals),
}

impl Light {
    /// The light to distribute and the scale of each contribution's geometry term, given the sum of all contributions'
    /// densities.
    fn shared(&self, density: f64, contested: &[Contested]) -> (Spectrum, f64) {
        match self {
            Self::ByCamera(alone, range) => {
                let add = |sum, of: &Contested| sum + of.light * of.rivals.camera(density) as f32;
                (contested[range.clone()].iter().fold(*alone, add), 1.0 / density)
            }
            Self::ByLight(light, scale, rivals) => (*light, FRAC_1_PI * scale * rivals.light(density)),
        }
    }
}

/// Distributes light among receivers.
pub fn distribute(
    paths: &mut [CameraPath],
    light: &Light,
    contested: &[Contested],
    contributions: impl Iterator<Item = (usize, Contribution)> + Clone,
) {
    let (light, scale) =
        light.shared(contributions.clone().map(|(_, contribution)| contribution.density).sum(), contested);
    for (receiver, contribution) in contributions {
        let factor = (contribution.geometry * scale) as f32;
        // Beyond the range the weight is beneath it, and infinity times zero would be no number. One that is none is
        // not hidden.
        let factor = if factor == f32::INFINITY { f32::MAX } else { factor };
        paths[receiver].radiance += contribution.weight * light * factor;
    }
}
