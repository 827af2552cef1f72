//! What a path has to share, and from where on.

use super::super::Path;
use super::super::stream::State;
use super::rivals::Tail;
use crate::bsdf::Bsdf;
use crate::integrator::Counters;
use crate::integrator::light::Vertex;
use crate::integrator::wavefront;
use crate::math::ray::{Ends, way_between};
use crate::math::{DVec3, Origin, Ray, length};
use crate::scene::{Scene, Side};
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// A point that a pixel sees, directly or by mirrors and smooth glass.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    pub p: DVec3,
    /// World, unit length, on the side that is seen.
    pub n: DVec3,
    pub primitive: u32,
    /// What becomes of light on its way from here to the camera, and of a matte point what it does itself.
    pub weight: Spectrum,
    /// `None` of a matte point.
    pub lobes: Option<Lobes>,
    /// Of the path from the camera, besides the one that ends here. Only receivers with as many share, for
    /// what a source is known to send depends on how many are left.
    pub edges: u32,
}

impl Receiver {
    /// Asks whether anything is between.
    pub fn ray_to(&self, source: &Source) -> Ray {
        between(Origin { p: self.p, primitive: self.primitive }, source.p)
    }
}

/// A point that a path came to from a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    pub p: DVec3,
    /// World, on the side where the path came from: its shading normal, on whose side it scatters.
    pub n: DVec3,
    /// World, of the surface itself, on either side: areas are its.
    pub ng: DVec3,
    pub primitive: u32,
    /// Of a matte point; else one.
    pub albedo: Spectrum,
    /// `None` of a matte point.
    pub lobes: Option<Lobes>,
}

impl Source {
    /// Asks whether anything is between.
    pub fn ray_to(&self, other: &Source) -> Ray {
        between(Origin { p: self.p, primitive: self.primitive }, other.p)
    }
}

fn between(Origin { p, primitive }: Origin, end: DVec3) -> Ray {
    let way = end - p;
    let distance = length(way);
    let ray = Ray::leaving(p, way / distance, way_between(distance, p, end), primitive);
    Ray { ends: Ends::OnSurfaces, ..ray }
}

/// Which of the rays between what pixels share are blocked.
pub fn ask(scene: &Scene, rays: &[Ray], occluded: &mut Vec<bool>, counters: &mut Counters) {
    counters.shared += rays.len() as u64;
    wavefront::occluded(scene, rays, occluded, counters);
}

/// How a receiver or a source scatters that is rough.
#[derive(Clone, Copy, Debug)]
pub struct Lobes {
    pub point: SurfacePoint,
    pub side: Side,
    /// Local, the direction that is the same whoever shares: from a receiver to where its path came from,
    /// from a source to where its path goes on.
    pub fixed: DVec3,
}

/// What a path has to share.
#[derive(Clone, Copy, Debug)]
pub struct Shared {
    pub receiver: Option<Receiver>,
    pub source: Option<Source>,
    /// What becomes of what is shared on its way to the path's own pixel.
    pub own: Spectrum,
    /// Besides what is [contested](super::rivals::Contested): the radiance that leaves a matte source or
    /// comes to a rough one, as far as it is known.
    pub radiance: Spectrum,
}

impl Shared {
    pub const NOTHING: Self =
        Self { receiver: None, source: None, own: Spectrum::ZERO, radiance: Spectrum::ZERO };

    /// Whether what casters throw is shared as well. What light paths make too is weighed for the pixel alone,
    /// but they do not reach the camera by mirrors or glass.
    #[inline(always)]
    pub fn receives_casters(&self, scene: &Scene) -> bool {
        scene.caustics.is_none() || self.receiver.as_ref().is_some_and(|receiver| receiver.edges > 0)
    }

    /// Notes a receiver or a source where the path has arrived, and whether what it finds from here on is
    /// shared.
    pub fn arrive<B: Bsdf>(
        &mut self,
        vertex: &Vertex<B>,
        settings: &Path,
        state: &mut State,
        λ: &Wavelengths,
    ) {
        let Vertex { point, primitive, side, .. } = *vertex;
        let albedo = vertex.bsdf.albedo();
        let faces = vertex.wo.z > 0.0 && (albedo.is_some() || side.traits.only_rough);
        // What is shared must not have been through roulette, whose chances depend on the pixel.
        let goes_on = state.depth + 1 < settings.rr_depth;
        let lobes = || albedo.is_none().then_some(Lobes { point: *point, side, fixed: vertex.wo });
        let begins = match (&self.receiver, &self.source) {
            (None, _) if faces && state.mirrored && goes_on => {
                let weight = state.throughput * albedo.unwrap_or(Spectrum::ONE);
                if !weight.is_zero() && !λ.is_collapsed() {
                    let (p, n, edges) = (point.p, vertex.to_world(DVec3::Z), state.depth);
                    self.receiver = Some(Receiver { p, n, primitive, weight, lobes: lobes(), edges });
                }
                false
            }
            // Light paths do not come to what is one-way.
            (Some(receiver), _) if state.depth == receiver.edges + 1 && !side.traits.one_way => {
                if faces && (albedo.is_some() || goes_on) {
                    let (p, n, ng) = (point.p, vertex.to_world(DVec3::Z), point.ng);
                    let (albedo, lobes) = (albedo.unwrap_or(Spectrum::ONE), lobes());
                    self.source = Some(Source { p, n, ng, primitive, albedo, lobes });
                }
                albedo.is_some() && faces
            }
            (Some(receiver), Some(Source { lobes: Some(_), .. })) => {
                state.depth == receiver.edges + 2 && side.traits.smooth
            }
            _ => false,
        };
        if begins {
            self.own = state.throughput;
            (state.throughput, state.eta2, state.shares) = (Spectrum::ONE, 1.0, true);
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
