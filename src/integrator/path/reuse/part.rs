//! What receivers have of a source.

use super::rivals::{Contested, Rivals};
use crate::integrator::CameraPath;
use crate::spectrum::Spectrum;
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

/// The part that a receiver has of the light of a source, not yet divided by the sum of densities. As if π
/// were 1: it cancels.
#[derive(Clone, Copy)]
pub struct Part {
    /// What scatters it on its way to the camera.
    pub weight: Spectrum,
    /// The rest, of which a number of the weight's might not hold the range.
    pub geometry: f64,
    /// With which the receiver's own path would have come to the source, in area, and gone on.
    pub density: f64,
}

impl Part {
    /// Of a matte source for a matte receiver.
    pub fn matte(weight: Spectrum, geometry: f64) -> Self {
        Self { weight, geometry, density: geometry }
    }
}

/// What leaves a source.
#[derive(Clone, Debug)]
pub enum Light {
    /// Of a camera path: what nothing else finds, and which of all [`Contested`] light.
    ByCamera(Spectrum, Range<usize>),
    /// Of a light path, but for a scale of which a lane might not hold the range.
    ByLight(Spectrum, f64, Rivals),
}

impl Light {
    /// The share of it that its own path has to hand on, and what the geometry of each part is to be
    /// multiplied with, if the densities of all parts sum to this.
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

/// Parts light among receivers.
pub fn hand_on(
    paths: &mut [CameraPath],
    (light, contested): (&Light, &[Contested]),
    parts: impl Iterator<Item = (usize, Part)> + Clone,
) {
    let (light, scale) = light.shared(parts.clone().map(|(_, part)| part.density).sum(), contested);
    for (receiver, part) in parts {
        paths[receiver].radiance += part.weight * light * (part.geometry * scale) as f32;
    }
}
