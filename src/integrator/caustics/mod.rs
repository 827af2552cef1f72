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
use crate::sensor::Sensor;
pub use emission::Emission;
pub use light_path::{Landing, Splat};

/// Light paths per camera path, until a pilot has found how much of the light they find; see
/// [`crate::render::plan`].
const LIGHT_PATHS: f64 = 0.25;

/// The light paths of a scene: how they start, and how many there are.
#[derive(Debug)]
pub struct Caustics {
    emission: Emission,
    /// Those of the camera paths, and how many emitter samples these take at a vertex.
    lengths: Lengths,
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
        let ratio = settings.light_paths.unwrap_or(LIGHT_PATHS);
        if settings.lengths.max_depth < 3 || ratio == 0.0 {
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

    /// The factor of r at xₙ, where w is the direction back to xₙ₋₁.
    pub fn last(&self, scene: &Scene, end: EmitterPoint, w: DVec3) -> f64 {
        f64::from(self.paths) * self.emission.over_cos(scene, end, w)
    }
}

/// Whether light paths are aimed at a shape: a side of it has narrow lobes.
pub fn is_caster(shape: &Shape) -> bool {
    shape.sides.iter().any(|side| side.traits.focuses())
}

/// The factor of r at x₁, whose lobe has the density `pdf`: no light path can be connected with the camera by
/// a lobe without one. `seen` is J.
pub fn first(pdf: f64, cos_light: f64, seen: f64) -> f64 {
    cos_light / (pdf * seen)
}

/// ρ of a vertex whose lobe has a density; `to_camera` and `to_light` are the densities with which either is
/// sampled from the other, and the cosines are those of the two directions.
pub fn further(to_camera: f64, to_light: f64, cos_camera: f64, cos_light: f64) -> f64 {
    to_camera * cos_light / (to_light * cos_camera)
}
