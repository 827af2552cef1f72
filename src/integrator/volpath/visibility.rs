//! How much light arrives between two points, through media and straight through surfaces.

use crate::bsdf::Bsdf;
use crate::integrator::Counters;
use crate::math::Ray;
use crate::medium::{FlightNumbers, Medium};
use crate::scene::Scene;
use crate::spectrum::{Spectrum, Wavelengths};

/// Most surfaces that a shadow ray passes; beyond, as good as nothing is left but where somebody has stacked
/// panes of nothing.
const MOST: u32 = 1 << 16;

/// The share of light that arrives along a shadow ray, which begins in `medium`.
pub fn between<'a, const F: u32>(
    scene: &'a Scene,
    mut ray: Ray,
    mut medium: Option<&'a Medium>,
    λ: &Wavelengths,
    numbers: &mut FlightNumbers,
    counters: &mut Counters,
) -> Spectrum {
    let mut passed = λ.ones();
    for _ in 0..MOST {
        counters.rays += 1;
        let hit = scene.accel.closest(&ray);
        let surface = hit.map(|hit| {
            let (shape, point) = scene.surface::<F>(&ray, &hit);
            (hit, shape, point, shape.side_towards(point.ns.dot(-ray.direction)))
        });
        // What is before a surface that nothing passes does not matter.
        if surface.as_ref().is_some_and(|(.., side)| !side.traits.has_null) {
            return Spectrum::ZERO;
        }
        if let Some(medium) = medium {
            let segment = Ray { end: hit.map_or(ray.end, |hit| hit.t), ..ray };
            passed *= medium.transmittance(&segment, λ, numbers);
        }
        let Some((hit, shape, point, side)) = surface else { return passed };
        let frame = side.frame::<F>(&point);
        let bsdf = scene.materials[side.material as usize].at(&point, λ);
        passed *= bsdf.null_transmission(frame.to_local(-ray.direction));
        if passed.is_zero() {
            return passed;
        }
        if let Some(interface) = shape.interface.as_deref() {
            medium = interface.towards(ray.direction.dot(point.ng));
        }
        // On along the same line: the computed point may lie off it by the rounding of something large, and the
        // ray would end in what it leads to.
        let onward = point.ray(ray.direction, ray.end - hit.t, hit.primitive);
        ray = Ray { origin: ray.at(hit.t), ..onward };
    }
    Spectrum::ZERO
}
