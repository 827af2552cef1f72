//! What a path shares, and from which vertex on.

use super::super::Path;
use super::super::stream::State;
use super::rivals::Tail;
use crate::bsdf::Bsdf;
use crate::integrator::Counters;
use crate::integrator::vertex::Vertex;
use crate::integrator::wavefront;
use crate::math::ray::{Ends, free_way};
use crate::math::{DVec3, Origin, Ray, length};
use crate::scene::{Scene, Side};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// A point that a pixel sees, directly or by mirrors and smooth glass.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    pub p: DVec3,
    /// A bound of the rounding error of `p`.
    pub error: f64,
    /// Shading normal (world, unit length), on the side that is seen.
    pub n: DVec3,
    pub primitive: u32,
    /// Throughput from here to the camera; for a matte point, times its albedo.
    pub weight: Spectrum,
    /// `None` for a matte point.
    pub lobes: Option<Lobes>,
    /// Edges from the camera, without the one that ends here. Only receivers with as many share, for what a
    /// source is known to send depends on how many are left.
    pub edges: u32,
}

impl Receiver {
    /// The shadow ray to a source.
    pub fn ray_to(&self, source: &Source) -> Ray {
        between(Origin { p: self.p, primitive: self.primitive }, self.error, source.p, source.error)
    }
}

/// A point that a path came to from a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    pub p: DVec3,
    /// A bound of the rounding error of `p`.
    pub error: f64,
    /// Shading normal (world), on the side where the path came from, which is the side that scatters.
    pub n: DVec3,
    /// Geometric normal (world), on either side; densities by area are about it.
    pub ng: DVec3,
    pub primitive: u32,
    /// Albedo of a matte point; for a rough one, 1.
    pub albedo: Spectrum,
    /// `None` for a matte point.
    pub lobes: Option<Lobes>,
}

impl Source {
    /// The shadow ray to another source.
    pub fn ray_to(&self, other: &Source) -> Ray {
        between(Origin { p: self.p, primitive: self.primitive }, self.error, other.p, other.error)
    }
}

/// The shadow ray between two points with these errors: so much shorter that neither point's own surface
/// occludes it.
fn between(Origin { p, primitive }: Origin, error: f64, end: DVec3, end_error: f64) -> Ray {
    let way = end - p;
    let distance = length(way);
    let ray = Ray::leaving(p, way / distance, free_way(distance, error + end_error), primitive);
    Ray { start: error, ends: Ends::OnSurfaces, ..ray }
}

/// Traces shadow rays between receivers and sources, and counts them as such.
pub fn trace_shadow_rays(scene: &Scene, rays: &[Ray], occluded: &mut Vec<bool>, counters: &mut Counters) {
    counters.shared += rays.len() as u64;
    wavefront::occluded(scene, rays, occluded, counters);
}

/// Everything that the BSDF of a rough receiver or source is evaluated from.
#[derive(Clone, Copy, Debug)]
pub struct Lobes {
    pub point: SurfacePoint,
    pub side: Side,
    /// The direction (local) that is the same for all that share: from a receiver to where its path came
    /// from, from a source to where its path goes on.
    pub fixed: DVec3,
}

/// What a path shares with its group.
#[derive(Clone, Copy, Debug)]
pub struct Shared {
    pub receiver: Option<Receiver>,
    pub source: Option<Source>,
    /// Throughput from where sharing begins to the path's own pixel.
    pub own: Spectrum,
    /// Radiance found so far that leaves a matte source or comes to a rough one, without what is
    /// [contested](super::rivals::Contested).
    pub radiance: Spectrum,
}

impl Shared {
    pub const NOTHING: Self =
        Self { receiver: None, source: None, own: Spectrum::ZERO, radiance: Spectrum::ZERO };

    /// Whether light that comes from a caster is shared as well. Where light paths compete for it, its MIS weight
    /// depends on the pixel, so it is not. They do not compete where the pixel sees its receiver by mirrors or
    /// through glass, to which no light path can be connected.
    #[inline(always)]
    pub fn receives_casters(&self, scene: &Scene) -> bool {
        scene.techniques.caustics.is_none()
            || self.receiver.as_ref().is_some_and(|receiver| receiver.edges > 0)
    }

    /// Notes the vertex as receiver or source if it is one, and whether what the path finds from here on is
    /// shared.
    pub fn arrive<B: Bsdf>(
        &mut self,
        scene: &Scene,
        vertex: &Vertex<B>,
        settings: &Path,
        state: &mut State,
        λ: &Wavelengths,
    ) {
        let Vertex { point, primitive, side, .. } = *vertex;
        let albedo = vertex.bsdf.albedo();
        let faces = vertex.wo.z > 0.0 && (albedo.is_some() || side.traits.only_rough);
        // What is shared must not have been through roulette, whose chances depend on the pixel.
        let goes_on = state.depth + 1 < settings.roulette.edges;
        let lobes = || albedo.is_none().then_some(Lobes { point: *point, side: *side, fixed: vertex.wo });
        let begins = match (&self.receiver, &self.source) {
            (None, _) if faces && state.specular_so_far && goes_on => {
                let weight = state.throughput * albedo.unwrap_or(Spectrum::ONE);
                if !weight.is_zero() && !λ.is_collapsed() {
                    let (p, n, edges) = (point.p, vertex.to_world(DVec3::Z), state.depth);
                    let error = scene.point_error(primitive, p);
                    self.receiver = Some(Receiver { p, error, n, primitive, weight, lobes: lobes(), edges });
                }
                false
            }
            // Light paths do not come to what is one-way.
            (Some(receiver), _) if state.depth == receiver.edges + 1 && !side.traits.irreversible => {
                if faces && (albedo.is_some() || goes_on) {
                    let (p, n, ng) = (point.p, vertex.to_world(DVec3::Z), point.ng);
                    let (albedo, lobes) = (albedo.unwrap_or(Spectrum::ONE), lobes());
                    let error = scene.point_error(primitive, p);
                    self.source = Some(Source { p, error, n, ng, primitive, albedo, lobes });
                }
                albedo.is_some() && faces
            }
            (Some(receiver), Some(Source { lobes: Some(_), .. })) => {
                state.depth == receiver.edges + 2 && side.traits.has_density
            }
            _ => false,
        };
        if begins {
            self.own = state.throughput;
            (state.throughput, state.eta2, state.shares) = (λ.ones(), 1.0, true);
            let matte = self.source.is_some_and(|source| source.lobes.is_none());
            if settings.shared_light_paths > 0 && matte {
                state.tail = Tail::BEGINS;
            }
        }
    }

    /// Notes in which direction (local) the path goes on from a source.
    #[inline(always)]
    pub fn leave(&mut self, state: &State, wi: DVec3) {
        let is_next = |receiver: &Receiver| state.depth == receiver.edges + 1;
        if self.receiver.as_ref().is_some_and(is_next)
            && let Some(Source { lobes: Some(lobes), .. }) = &mut self.source
        {
            lobes.fixed = wi;
        }
    }
}
