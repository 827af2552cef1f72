//! What receivers have of a source.

use crate::integrator::CameraPath;
use crate::spectrum::Spectrum;

/// The part that a receiver has of the light of a source, not yet divided by the sum of densities. As if π were 1: it cancels.
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

/// Parts light among receivers.
pub fn hand_on(
    paths: &mut [CameraPath],
    light: Spectrum,
    parts: impl Iterator<Item = (usize, Part)> + Clone,
) {
    let all = 1.0 / parts.clone().map(|(_, part)| part.density).sum::<f64>();
    for (receiver, part) in parts {
        paths[receiver].radiance += part.weight * light * (part.geometry * all) as f32;
    }
}
