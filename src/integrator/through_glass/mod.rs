//! Emitter samples through glass.
//!
//! A shadow ray ends at glass, so light from behind it is left to paths that happen to hit the emitter, and to light paths; but where
//! the surface is itself seen through glass or in a mirror, those cannot be connected with the camera. There is a bent way
//! from the surface to the sampled point of the emitter, and [`Link`] finds it: manifold next-event
//! estimation (Hanika, Droske & Fascione 2015), for interfaces that only refract or reflect.
//!
//! **The density.** A point y of the emitter with density pₐ(y) by area stands for the direction ω in which the way to it leaves the vertex, with
//! the density p(ω) = pₐ(y) |∂y/∂ω|: the derivatives along the way tell the area |∂y⊥/∂ω| across the ray,
//! and the emitter is hit at an angle, so p(ω) = pₐ(y) |∂y⊥/∂ω| / cos θ_y. The straight line's density of directions p′ gives pₐ = p′ cos θ′_y / d².
//!
//! **The weights.** There may be other ways to y, with other interfaces or other bends; they are left to paths that scatter into them. So
//! when such a path has left a vertex by a lobe with a density, gone through interfaces and met the emitter, the link between
//! vertex and emitter is found again: only if it is this very way could an emitter sample have made the path, and the
//! power heuristic shares it, of p(ω) and the density of the scattering times the chance of going through each interface.
//! What is found depends on the two points alone, so both sides agree; and so do light paths, the third technique (see
//! [`caustics`](super::caustics)), which look for the link as soon as they are through glass.

mod link;

use super::Counters;
use super::light::{Proposal, Vertex, power_heuristic_of_three};
use crate::bsdf::{Bsdf, Sample};
use crate::emitter::AnyEmitter;
use crate::math::ray::{position_error, way_between};
use crate::math::{DVec2, DVec3, Ray, length};
use crate::scene::{Scene, Shape, Side};
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;
pub use link::{Link, goes_through};

/// Directions closer than this are the same: those that Newton's method finds are far closer, other ways are farther.
const SAME: f64 = 1e-6;

/// At which vertices emitters are sampled through glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Where {
    /// A pilot of the scene decides between the last two.
    Auto,
    Never,
    /// Where no light path can be connected with the camera.
    Unaided,
    Everywhere,
}

impl Where {
    /// Their names in scene files, in order.
    pub const NAMES: [&str; 4] = ["auto", "never", "unaided", "everywhere"];

    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Auto, Self::Never, Self::Unaided, Self::Everywhere];
        all.into_iter().zip(Self::NAMES).find(|(_, known)| *known == name).map(|(one, _)| one)
    }
}

/// Where there is glass in a scene.
#[derive(Debug)]
pub struct Glass {
    /// Boxes around shapes; where there are many, one around all.
    boxes: Vec<(DVec3, DVec3)>,
    /// All vertices sample emitters through it, not only those that light paths cannot help.
    pub everywhere: bool,
}

impl Glass {
    /// `None` if there is none, or no shape that shines.
    pub fn of(shapes: &[Shape]) -> Option<Self> {
        const FEW: usize = 8;
        let refracting = shapes.iter().filter(|shape| shape.refracts());
        let mut boxes: Vec<_> = refracting.map(|shape| shape.geometry.bounds()).collect();
        if boxes.len() > FEW {
            let all = boxes.iter().copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
            boxes = all.into_iter().collect();
        }
        (!boxes.is_empty() && shapes.iter().any(|shape| shape.emitter.is_some()))
            .then_some(Self { boxes, everywhere: false })
    }

    /// Whether some may lie on the way from a point to `distance` in unit direction `w`.
    pub fn may_be_between(&self, p: DVec3, w: DVec3, distance: f64) -> bool {
        // Of a direction along a side 0 · ∞ must not arise.
        let inverse = w.map(|w| 1.0 / if w == 0.0 { f64::MIN_POSITIVE } else { w });
        self.boxes.iter().any(|(lo, hi)| {
            let (a, b) = ((*lo - p) * inverse, (*hi - p) * inverse);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            enter <= leave && enter <= distance && leave >= 0.0
        })
    }
}

/// What a path has been through since it left a vertex that sampled emitters through glass.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    from: (DVec3, u32),
    direction: DVec3,
    /// The density of the direction, times the chance of going through the interfaces since.
    pdf: f64,
    interfaces: u32,
    /// It is none, or has met something else than interfaces.
    lost: bool,
}

impl Way {
    pub const NONE: Self =
        Self { from: (DVec3::ZERO, 0), direction: DVec3::ZERO, pdf: 0.0, interfaces: 0, lost: true };

    /// Leaves a vertex in a sampled direction (world).
    pub fn begin(from: (DVec3, u32), direction: DVec3, sample: &Sample) -> Self {
        Self { from, direction, pdf: sample.pdf, interfaces: 0, lost: sample.delta }
    }

    /// Goes on from a vertex without emitter samples.
    pub fn follow(&mut self, wo: DVec3, side: Side, sample: &Sample) {
        self.lost |= !goes_through(side, wo, sample);
        self.pdf *= sample.pdf;
        self.interfaces += 1;
    }

    /// How much likelier `count` emitter samples make the path that has met a point of an emitter.
    pub fn rival(
        &self,
        scene: &Scene,
        end: (usize, &SurfacePoint),
        count: f64,
        λ: &Wavelengths,
        counters: &mut Counters,
    ) -> f64 {
        if self.lost || self.interfaces == 0 {
            return 0.0;
        }
        let way = (self.direction, self.interfaces);
        density_of(scene, self.from, way, end, λ, counters).map_or(0.0, |pdf| pdf * count / self.pdf)
    }
}

/// The density with which one emitter sample at a vertex makes a direction that leads through a number of interfaces to a point of an
/// emitter; `None` if there is another way that it would take, or none.
pub fn density_of(
    scene: &Scene,
    from: (DVec3, u32),
    (direction, interfaces): (DVec3, u32),
    (emitter, point): (usize, &SurfacePoint),
    λ: &Wavelengths,
    counters: &mut Counters,
) -> Option<f64> {
    let entry = &scene.emitters.list[emitter];
    let geometry = &scene.shapes[entry.shape? as usize].geometry;
    let towards = point.p - from.0;
    let distance = length(towards);
    let straight = Ray::leaving(from.0, towards / distance, distance, from.1);
    if straight.direction.dot(point.ng) >= 0.0 {
        return None;
    }
    let end = way_between(distance, point.p, from.0);
    let link = Link::find(scene, from, (straight.direction, end), interfaces as usize, λ, counters)?;
    let same = length(link.direction - direction) < SAME && link.last.direction.dot(point.ng) < 0.0;
    let pdf = entry.emitter.surface_pdf(geometry, &straight, distance, point);
    let chosen = scene.emitters.probability(emitter);
    same.then(|| chosen * density(pdf, (straight.direction, distance), &link, point.ng))
}

/// p(ω) from p′, the straight way, the bent one, and the emitter's normal.
fn density(straight_pdf: f64, (straight, distance): (DVec3, f64), link: &Link, n: DVec3) -> f64 {
    straight_pdf * (n.dot(straight) / (n.dot(link.last.direction) * distance * distance)).abs() * link.spread
}

/// One emitter sample out of `count`, if what is between the vertex and the emitter is glass: an estimate of the light that this
/// technique has to contribute, up to visibility behind the last interface. `light_paths` says of a link, of the density of its direction when scattering, and of an
/// emitter with a point and a normal there, how much likelier light paths make the whole path than scattering does.
pub fn sample_emitter<B: Bsdf>(
    scene: &Scene,
    vertex: &Vertex<B>,
    (choice, u): (f64, DVec2),
    (count, most): (f64, usize),
    λ: &Wavelengths,
    light_paths: impl Fn(&Link, f64, (usize, DVec3, DVec3)) -> f64,
    counters: &mut Counters,
) -> Option<Proposal> {
    let (index, probability, _) = scene.emitters.sample(choice)?;
    let entry = &scene.emitters.list[index];
    if !matches!(entry.emitter, AnyEmitter::Area(_)) {
        return None;
    }
    let shape = entry.shape.map(|i| &scene.shapes[i as usize].geometry);
    let from = (vertex.point.p, vertex.primitive);
    let light = entry.emitter.sample(shape, (from.0, DVec3::ZERO), u, λ)?;
    if light.radiance.is_zero() {
        return None;
    }
    let straight = (light.wi, light.distance);
    let link = Link::find(scene, from, straight, most, λ, counters)?;
    let cos = -link.last.direction.dot(light.n);
    if cos <= 0.0 {
        return None;
    }
    // Beside the point the emitter's surface may come earlier by this.
    let early = 2.0 * link.miss / cos + 4.0 * position_error(link.last.origin);
    let scattered = vertex.bsdf.evaluate(vertex.wo, vertex.to_local(link.direction));
    let pdf = density(light.pdf, straight, &link, light.n) * probability * count;
    if scattered.value.is_zero() || pdf.is_nan() || pdf <= 0.0 {
        return None;
    }
    let scattering = scattered.pdf * link.chance;
    let end = (index, from.0 + light.wi * light.distance, light.n);
    let by_light_path = scattering * light_paths(&link, scattered.pdf, end);
    let weight = power_heuristic_of_three(scattering / pdf, by_light_path / pdf);
    Some(Proposal {
        ray: Ray { end: link.last.end - early, ..link.last },
        radiance: scattered.value * link.transmittance * light.radiance * (weight / pdf) as f32,
    })
}

#[cfg(test)]
mod tests;
