//! Light tracing of caustics, and its MIS weights against camera paths.
//!
//! A path tracer finds light that a mirror or glass casts upon a surface only by chance: it must hit the
//! emitter by following the specular chain from the surface. From the other end, that is easy. So beside the
//! camera paths there are *light paths*: they leave an emitter, aimed at what is specular, and every rough
//! surface that they reach beyond is connected with the camera.
//!
//! **Which paths.** Let x₁ … xₙ be the vertices from the one that the camera sees to the one on the emitter.
//! Light paths make those with n ≥ 3 whose xₙ₋₁ is of a material with narrow lobes (a *caster*), whose xₙ
//! lies on an area emitter, and whose x₁ has a lobe with a density; they do not follow specular lobes under a
//! relief, whose weights are not the same from either end (`Traits::relief`). All others are left to camera
//! paths alone. Where xₙ₋₁ has a lobe with a density, emitter sampling makes these paths too; the three
//! techniques share them by the power heuristic.
//!
//! **The ratio of the densities.** Per sample number there is one camera path to each pixel, and there are M
//! light paths for the film. With area densities, the squared distances of all edges between x₁ and xₙ cancel
//! between the two, and
//!
//! r = p_light / p_camera = M pₐ(xₙ) p(xₙ→xₙ₋₁) / cosₙ · ∏ ρᵢ (i = n−1 … 2) · cos₁ / (p(x₁→x₂) J),
//!
//! where at vertex i, with the directions ωl to the light's side and ωc to the camera's side,
//!
//! ρᵢ = p(ωl→ωc) |cos ωl| / (p(ωc→ωl) |cos ωc|),
//!
//! which is 1 on a matte surface, cos₁ is that of ωl at x₁, and J is how many pixels (in px²) the film sees
//! for each unit of area about x₁. A lobe without density is chosen with the same probability from either
//! end; what is left of ρᵢ there is the change of the étendue, 1/η² with η = η(light's side)/η(camera's
//! side). Cosines are those of geometric normals. Russian roulette is not in the densities: the weights sum
//! to one without it.
//!
//! **The estimate.** The integrand in area measure, over the density of the light path, leaves at every
//! vertex f |cos ωl|ₛ · |cos ωc| / (p(ωl→ωc) |cos ωl|), with the shading cosine (index s) that the camera
//! path would have used: the correction that shading normals need (Veach 1997, §5.3) is in it. At x₁ it is
//! f |cos ωl|ₛ / |cos ωl| · J / M.

mod aim;
mod connections;
mod emission;
mod light_path;
mod stream;

use super::AnyIntegrator;
use super::lengths::Lengths;
use crate::emitter::{EmitterPoint, Emitters};
use crate::math::DVec3;
use crate::scene::instances::Instances;
use crate::scene::{Scene, Shape};
use crate::sensor::{Optics, Sensor};
pub use emission::Emission;
pub use light_path::{Landing, Splat};

/// Light paths per camera path, until a pilot has found how much of the light they find; see
/// [`crate::render::plan`].
pub const DEFAULT_RATIO: f64 = 0.25;

/// The light paths of a scene: how they start, and how many there are.
#[derive(Debug)]
pub struct Caustics {
    emission: Emission,
    /// How long camera paths may become; light paths make the same.
    lengths: Lengths,
    /// How many emitter samples camera paths take at a vertex.
    emitter_samples: f64,
    /// M, the number of light paths per sample number.
    pub paths: u32,
}

impl Caustics {
    /// `None` without casters or area emitters, or if the integrator's settings exclude light paths.
    pub fn plan(
        integrator: &AnyIntegrator,
        sensor: &Sensor,
        shapes: &[Shape],
        instances: &Instances,
        emitters: &Emitters,
    ) -> Option<Self> {
        let settings = integrator.path()?;
        let ratio = settings.light_paths;
        if settings.lengths.max_depth < 3 || ratio == 0.0 || !sensor.camera.has_image() {
            return None;
        }
        let emission = Emission::new(emitters, shapes, instances)?;
        let (lengths, emitter_samples) = (settings.lengths, f64::from(settings.emitter_samples));
        let mut caustics = Self { emission, lengths, emitter_samples, paths: 0 };
        caustics.set_ratio(ratio, sensor.film.crop.pixels());
        Some(caustics)
    }

    /// Sets the number of light paths per camera path.
    pub fn set_ratio(&mut self, ratio: f64, pixels: usize) {
        self.paths = (ratio * pixels as f64).ceil().min(f64::from(u32::MAX)) as u32;
    }

    /// The factor of r at xₙ, M pₐ(xₙ) p(xₙ→xₙ₋₁) / cosₙ, where w is the direction back to xₙ₋₁.
    pub fn ratio_at_emitter(&self, scene: &Scene, end: EmitterPoint, w: DVec3) -> f64 {
        f64::from(self.paths) * self.emission.density_over_cos(scene, end, w)
    }
}

/// One of the two directions by which a path leaves a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// The density in sr⁻¹ with which it is sampled where the path comes by the other.
    pub pdf: f64,
    /// The cosine with the geometric normal, without its sign.
    pub cos: f64,
}

/// The factor of r at x₁, cos₁ / (p(x₁→x₂) J), whose lobe must have a density: no light path can be connected
/// with the camera by a lobe without one. `seen` is J.
pub fn ratio_at_camera(to_light: Leg, seen: f64) -> f64 {
    to_light.cos / (to_light.pdf * seen)
}

/// ρᵢ, the factor of r at a vertex between these two whose lobe has a density.
pub fn ratio_at_vertex(to_camera: Leg, to_light: Leg) -> f64 {
    to_camera.pdf * to_light.cos / (to_light.pdf * to_camera.cos)
}
