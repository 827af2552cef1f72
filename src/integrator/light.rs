//! Direct light by sampling the emitters, and the MIS weights between that and sampling the BSDF.

use crate::bsdf::{Bsdf, Lobe};
use crate::emitter::{Choice, DirectSample, EmitterPoint, Gathers, MapPlace, Radiance};
use crate::math::ray::Ends;
use crate::math::{Chosen, DVec3, Frame, Origin, Ray};
use crate::sampler::EmitterNumbers;
use crate::scene::{Scene, Side};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// The power heuristic with exponent 2 (Veach 1997, §9.2.4), as 1/(1 + (b/a)²): densities are never squared
/// alone, so none can overflow.
#[inline]
pub fn power_heuristic(a: f64, b: f64) -> f64 {
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}

/// The power heuristic of three techniques, from the densities of the other two over that of this one.
#[inline]
pub fn power_heuristic_of_three(b_over_a: f64, c_over_a: f64) -> f64 {
    1.0 / (1.0 + b_over_a * b_over_a + c_over_a * c_over_a)
}

/// A surface point where light is gathered.
pub struct Vertex<'a, B> {
    pub point: &'a SurfacePoint,
    pub primitive: u32,
    /// That of the side; see [`Side::frame`].
    pub frame: &'a Frame,
    pub bsdf: &'a B,
    /// Direction to where the path came from, in the frame: on a light path that is the light's side, not the
    /// camera's.
    pub wo: DVec3,
    pub side: &'a Side,
}

impl<'a, B> Vertex<'a, B> {
    /// The origin of rays that leave it.
    #[inline]
    pub fn origin(&self) -> Origin {
        Origin { p: self.point.p, primitive: self.primitive }
    }

    /// A vertex with this frame; `wo` is in world space, and is taken into the frame.
    #[inline]
    pub fn new(
        point: &'a SurfacePoint,
        primitive: u32,
        frame: &'a Frame,
        bsdf: &'a B,
        side: &'a Side,
        wo: DVec3,
    ) -> Self {
        Self { point, primitive, frame, bsdf, wo: frame.to_local(wo), side }
    }

    /// A world direction in the frame's coordinates.
    #[inline]
    pub fn to_local(&self, w: DVec3) -> DVec3 {
        self.frame.to_local(w)
    }

    /// A direction of the frame's coordinates in world space.
    #[inline]
    pub fn to_world(&self, w: DVec3) -> DVec3 {
        self.frame.to_world(w)
    }

    /// The normal (world) of the hemisphere from which light can be scattered, by the cosine or nearly; zero
    /// if light from outside any one hemisphere can be. `to_camera` is the direction (local) it is scattered in.
    #[inline]
    fn gathers_about(&self, to_camera: DVec3) -> DVec3 {
        let traits = self.side.traits;
        let normal = if traits.transmits || traits.relief { DVec3::ZERO } else { self.frame.n };
        if to_camera.z < 0.0 { -normal } else { normal }
    }
}

impl<B: Bsdf> Vertex<'_, B> {
    /// What sampling emitters needs to know of it: its lobe, too, where one of several is chosen. `to_camera`
    /// is the direction (local) in which their light is scattered, whichever end the path came from.
    #[inline]
    pub fn gathers(&self, scene: &Scene, to_camera: DVec3) -> Gathers {
        if !scene.emitters.chosen_by_place() {
            return Gathers::about(self.gathers_about(to_camera));
        }
        let lobe = self.bsdf.lobe(to_camera);
        let lobe =
            if lobe.share > 0.0 { Lobe { axis: self.to_world(lobe.axis), ..lobe } } else { Lobe::NONE };
        Gathers { n: self.gathers_about(to_camera), lobe }
    }
}

/// A contribution, and the shadow ray that decides whether it arrives.
#[derive(Clone, Copy, Debug)]
pub struct Proposal {
    /// Shadow ray to just before the emitter, from the vertex or, along a link, from its last surface.
    pub ray: Ray,
    /// Contribution to the radiance that leaves the vertex towards `wo`, with its MIS weight.
    pub radiance: Spectrum,
    /// The place in the environment map with whose radiance the contribution is to be multiplied.
    pub of: Option<MapPlace>,
}

impl Proposal {
    /// The whole contribution.
    #[inline]
    pub fn radiance(&self, scene: &Scene, λ: &Wavelengths) -> Spectrum {
        self.of.as_ref().map_or(self.radiance, |place| self.radiance * scene.emitters.mapped(place, λ))
    }
}

/// An emitter sample, and how likely it was.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    pub emitter: usize,
    pub light: DirectSample,
    /// Density of its direction, summed over all samples of both techniques, in sr⁻¹.
    pub density: f64,
}

/// How many samples each technique takes at a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    pub emitter: f64,
    pub bsdf: f64,
}

impl Samples {
    pub const ONE: Self = Self { emitter: 1.0, bsdf: 1.0 };
}

/// One emitter sample of so many, weighted against those of the BSDF: an estimate of the direct light that
/// this technique has to contribute, up to visibility.
///
/// With n light samples of density p and m BSDF samples of density q, the multi-sample power heuristic gives
/// a light sample the weight (np)²/((np)² + (mq)²), and its estimate is divided by n. `light_paths` gives,
/// for an emitter, a sample and its density np, the ratio to np of the density with which light paths make
/// the whole path, as one of directions; see [`super::caustics`]. `choice` is that at the vertex.
#[inline]
pub fn sample_emitter<B: Bsdf>(
    scene: &Scene,
    vertex: &Vertex<B>,
    choice: &Choice,
    numbers: EmitterNumbers,
    samples: Samples,
    λ: &Wavelengths,
    light_paths: impl Fn(usize, &DirectSample, f64) -> f64,
) -> Option<(Proposal, Sampled)> {
    let Chosen { index, probability, rest: u } = choice.sample(&scene.emitters, numbers)?;
    let entry = &scene.emitters.list[index];
    let shape = entry.shape.map(|i| &scene.shapes[i as usize].geometry);
    let light = entry.emitter.sample(shape, choice.at.p, choice.at.gathers.n, u, λ)?;
    let scattered = vertex.bsdf.evaluate(vertex.wo, vertex.to_local(light.wi));
    let (radiance, of) = match light.radiance {
        Radiance::Known(radiance) => (scattered.value * radiance, None),
        Radiance::Mapped(place) => (scattered.value, Some(place)),
    };
    if radiance.is_zero() {
        return None;
    }
    let pdf = light.pdf * probability;
    let weight = if light.delta {
        1.0
    } else {
        let own = samples.emitter * pdf;
        power_heuristic_of_three(samples.bsdf * scattered.pdf / own, light_paths(index, &light, own))
    };
    let ray = Ray::leaving(vertex.point.p, light.wi, light.distance, vertex.primitive);
    let proposal = Proposal {
        ray: if entry.shape.is_some() { Ray { ends: Ends::OnSurfaces, ..ray } } else { ray },
        radiance: radiance * (weight / (pdf * samples.emitter)) as f32,
        of,
    };
    let density = samples.emitter * pdf + samples.bsdf * scattered.pdf;
    Some((proposal, Sampled { emitter: index, light, density }))
}

/// The density in sr⁻¹ with which all emitter samples of a camera path's vertex together find a point of an
/// emitter, in direction w (world) and at this distance, if the path has come from `to_camera` (local).
pub fn density_of_finding<B: Bsdf>(
    scene: &Scene,
    end: EmitterPoint,
    vertex: &Vertex<B>,
    to_camera: DVec3,
    w: DVec3,
    distance: f64,
) -> f64 {
    let entry = &scene.emitters.list[end.emitter];
    let (Some(shape), Some(path)) = (entry.shape, scene.integrator.path()) else { return 0.0 };
    let there = SurfacePoint::plain(end.p, end.n, end.n);
    let (p, geometry) = (vertex.point.p, &scene.shapes[shape as usize].geometry);
    let pdf = entry.emitter.surface_pdf(geometry, &Ray::free(p, w), distance, &there);
    let gathers = vertex.gathers(scene, to_camera);
    Choice::at(gathers.at(p)).density_of_samples(&scene.emitters, end.emitter, pdf, path.emitter_samples)
}

#[cfg(test)]
mod tests {
    use super::power_heuristic;

    #[test]
    fn weights_sum_to_one_at_any_scale() {
        for (a, b) in [(1.0, 3.0), (1e200, 3e200), (1e-300, 1e300), (0.0, 1.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-15, "{a} {b}");
        }
    }
}
