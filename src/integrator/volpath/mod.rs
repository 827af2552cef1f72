//! Path tracing through participating media.
//!
//! Between surfaces light obeys the radiative transfer equation (Chandrasekhar 1960),
//!
//! (ω·∇) L = −σₜ L + σₛ ∫ p(ω, ω′) L(ω′) dω′,
//!
//! so along a ray of length d, with the transmittance T(t) = exp(−∫₀ᵗ σₜ),
//!
//! L(0) = T(d) L(d) + ∫₀ᵈ T(t) σₛ(t) ∫ p(ω, ω′) L(t, ω′) dω′ dt.
//!
//! A path draws how far it gets ([`crate::medium`]), and where it is scattered it samples an emitter and the
//! phase function as a surface's vertex samples an emitter and the BSDF. As in Mitsuba, surfaces that let
//! light straight through (`null`, `mask`, `thindielectric`) are seen by emitter samples for what they are,
//! and passing one is no edge of the path.

mod visibility;
mod walk;

use super::MAX_VERTICES;
use super::lengths::Lengths;
use super::path::Path;
use super::{AnyIntegrator, CameraPath, Counters};
use crate::scene::Scene;
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::spectrum::Spectrum;
use walk::Walk;

pub const NAME: &str = "volpath";
pub const ABOUT: &str = "Path tracing through participating media and straight through surfaces, unbiased; `path` in scenes without either.";
pub const EXAMPLES: &[&str] = &[
    r#"<integrator type="volpath"/>"#,
    r#"<integrator type="volpath"><integer name="max_depth" value="64"/><integer name="rr_depth" value="16"/></integrator>"#,
];

/// The settings.
#[derive(Clone, Copy, Debug)]
pub struct VolPath {
    lengths: Lengths,
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    Ok(AnyIntegrator::VolPath(VolPath { lengths: Lengths::parse(params)? }))
}

impl VolPath {
    /// The path tracer of surfaces with the same settings, and with all others as if none was given.
    pub fn without_media(self) -> Path {
        Path::of(self.lengths)
    }

    /// Estimates the radiance along a camera ray.
    pub fn radiance<const F: u32>(
        &self,
        scene: &Scene,
        path: &mut CameraPath,
        counters: &mut Counters,
    ) -> Spectrum {
        // Surroundings in view cover everything.
        path.covered = !self.lengths.hide_emitters && scene.emitters.environment.is_some();
        if self.lengths.max_depth == 0 {
            return Spectrum::ZERO;
        }
        let mut walk = Walk::from_camera(self.lengths, scene, path, counters);
        walk.begin::<F>();
        for edge in 1..=MAX_VERTICES {
            if walk.step::<F>(edge).is_none() {
                return walk.radiance;
            }
        }
        let radiance = walk.radiance;
        counters.cut += 1;
        radiance
    }
}

#[cfg(test)]
mod tests;
