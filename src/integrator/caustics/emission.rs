//! Sampling of a light path's first edge.

use super::aim::{Aim, BALLS, bundled};
use crate::emitter::select::SceneEmitter;
use crate::emitter::{AnyEmitter, EmitterPoint, Emitters};
use crate::math::{Ball, Chosen, DVec3, Discrete, Ray};
use crate::sampler::{EmitterNumbers, Numbers};
use crate::scene::instances::Instances;
use crate::scene::{Scene, Shape};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// Most balls around casters of instances, unless there are more instances.
const ENOUGH: usize = 4096;

/// Chooses an area emitter by its power, a point of it uniformly, and a direction aimed at casters.
#[derive(Debug)]
pub struct Emission {
    /// Probabilities of all emitters; zero for those without a surface.
    choice: Discrete,
    aim: Aim,
}

/// The first edge of a light path.
pub struct Start {
    pub end: EmitterPoint,
    pub ray: Ray,
    pub radiance: Spectrum,
    /// Cosine between the ray and the emitter's normal.
    pub cos: f64,
    /// Joint density of the point and the direction, in m⁻²·sr⁻¹.
    pub density: f64,
}

impl Emission {
    /// Aimed at the casters. `None` without casters or without area emitters.
    pub fn new(emitters: &Emitters, shapes: &[Shape], instances: &Instances) -> Option<Self> {
        let balls = |shapes: &[Shape]| -> Vec<Ball> {
            shapes.iter().filter(|shape| shape.is_caster()).map(|shape| shape.geometry.ball()).collect()
        };
        // Of a hundred thousand instances most balls would be thrown away again.
        let most = (ENOUGH / instances.len().max(1)).clamp(1, BALLS);
        let groups: Vec<Vec<Ball>> = instances.groups().map(|shapes| bundled(balls(shapes), most)).collect();
        let placed = instances
            .placements()
            .flat_map(|(group, to_world)| groups[group].iter().map(|ball| ball.placed(to_world)));
        let casters: Vec<Ball> = balls(shapes).into_iter().chain(placed).collect();
        if casters.is_empty() { None } else { Self::aimed(emitters, shapes, Aim::new(casters)) }
    }

    /// With directions by the cosine, not aimed. `None` without area emitters.
    pub fn everywhere(emitters: &Emitters, shapes: &[Shape]) -> Option<Self> {
        Self::aimed(emitters, shapes, Aim::everywhere())
    }

    fn aimed(emitters: &Emitters, shapes: &[Shape], aim: Aim) -> Option<Self> {
        let power = |entry: &SceneEmitter| match (&entry.emitter, entry.shape) {
            (AnyEmitter::Area(area), Some(shape)) => area.power(&shapes[shape as usize].geometry),
            _ => 0.0,
        };
        let choice = Discrete::new(emitters.list.iter().map(power));
        let some = choice.total() > 0.0 && choice.total().is_finite();
        some.then_some(Self { choice, aim })
    }

    /// Samples a point and a direction. `None` if no light leaves there.
    pub fn sample(
        &self,
        emitters: &Emitters,
        shapes: &[Shape],
        u: &Numbers,
        λ: &Wavelengths,
    ) -> Option<Start> {
        let EmitterNumbers { place, digits } = u.emission();
        let Chosen { index, probability, rest: place } = self.choice.sample_strip(place, digits);
        let entry = &emitters.list[index];
        let shape = &shapes[entry.shape? as usize];
        let start = shape.geometry.sample_area::<true>(place);
        let end = EmitterPoint { emitter: index, p: start.p, n: start.n };
        let aimed = self.aim.from(end.p, end.n);
        let (direction, which) = u.aim();
        let w = aimed.sample(direction, which);
        let density = probability * start.pdf * aimed.density(w);
        if density == 0.0 {
            return None;
        }
        let point =
            SurfacePoint { uv: start.uv, ..SurfacePoint::plain(start.p, start.n, start.n, start.error) };
        let radiance = entry.emitter.surface_radiance(&point, w, λ);
        let ray = point.ray(w, f64::INFINITY, shape.first_primitive + start.primitive);
        (!radiance.is_zero()).then(|| Start { end, ray, radiance, cos: w.dot(start.n), density })
    }

    /// The density with which [`Emission::sample`] makes a point and the direction w from it, in m⁻²·sr⁻¹,
    /// over the cosine between w and the normal there.
    pub fn density_over_cos(&self, scene: &Scene, end: EmitterPoint, w: DVec3) -> f64 {
        let Some(shape) = scene.emitters.list[end.emitter].shape else { return 0.0 };
        let pdf = 1.0 / scene.shapes[shape as usize].geometry.area();
        let density = self.choice.probability(end.emitter) * pdf * self.aim.from(end.p, end.n).density(w);
        // No light leaves at a right angle, and no ratio is taken of it.
        if density > 0.0 { density / end.n.dot(w).abs() } else { 0.0 }
    }
}
