//! A light path: its state, its scattering, and its connections with the camera.

use super::connections::Connections;
use super::{Caustics, Leg, ratio_at_camera, ratio_at_vertex};
use crate::bsdf::{Bsdf, Material, Visitor};
use crate::emitter::EmitterPoint;
use crate::integrator::Counters;
use crate::integrator::emitter_sampling::density_of_finding;
use crate::integrator::links::{SpecularChain, density_of};
use crate::integrator::mis::power_heuristic_of_ratios;
use crate::integrator::roulette::roulette;
use crate::integrator::vertex::Vertex;
use crate::math::{DVec2, DVec3, Ray};
use crate::sampler::Numbers;
use crate::scene::{Scene, Side};
use crate::sensor::Optics;
use crate::shape::{Hit, SurfacePoint};
use crate::spectrum::{Spectrum, Wavelengths};

/// The contribution of a light path to a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    pub pixel: (u32, u32),
    pub λ: Wavelengths,
    pub radiance: Spectrum,
    /// Factor of `radiance`, with the MIS weight and the reconstruction filter: its range exceeds that of the
    /// lanes.
    pub weight: f64,
}

/// The state of a light path between two vertices.
pub struct LightPath {
    /// Its place in its stream.
    pub index: usize,
    λ: Wavelengths,
    emitted: Spectrum,
    /// Product of the factors of the estimate at all vertices beyond the emitter so far.
    throughput: Spectrum,
    /// cos / density at the emitter, apart from the throughput: a lane might not hold it.
    scale: f64,
    /// Product of the factors of r so far; see [`super`].
    ratio: f64,
    /// The sampled point of the emitter.
    end: EmitterPoint,
    /// The density of emitter sampling at the first vertex with a density, over that of BSDF sampling there,
    /// both as of a path from the camera. Zero if emitter sampling cannot make the edges before it.
    by_emitter: f64,
    /// The specular chain since the emitter; `None` once no link could lead by it.
    chain: Option<SpecularChain>,
}

impl LightPath {
    /// The path at a place in its stream, and its first ray; `None` if no light leaves there. `u` is the block
    /// [`START`] of its sampler.
    ///
    /// [`START`]: crate::sampler::blocks::START
    #[inline(always)]
    pub fn begin(
        caustics: &Caustics,
        scene: &Scene,
        index: usize,
        u: &Numbers,
        λ: Wavelengths,
    ) -> Option<(Self, Ray)> {
        let start = caustics.emission.sample(&scene.emitters, &scene.shapes, u, &λ)?;
        let scale = start.cos / start.density;
        let path = Self {
            index,
            λ,
            emitted: start.radiance,
            throughput: λ.ones(),
            scale,
            ratio: f64::from(caustics.paths) / scale,
            end: start.end,
            by_emitter: 0.0,
            chain: Some(SpecularChain::BEGUN),
        };
        Some((path, start.ray))
    }
}

/// The hit at the end of a light path's ray.
pub struct Landing<'a> {
    pub ray: &'a Ray,
    pub hit: Hit,
    /// Edges of the path from the emitter to the hit.
    pub edges: u32,
    pub u: &'a Numbers,
}

impl Caustics {
    /// Connects the vertex at the hit with the camera, and samples the next ray; `None` ends the path.
    #[inline(always)]
    pub fn step<const F: u32>(
        &self,
        scene: &Scene,
        path: &mut LightPath,
        landing: Landing,
        connections: &mut Connections,
        counters: &mut Counters,
    ) -> Option<Ray> {
        let (shape, point) = scene.surface::<F>(landing.ray, &landing.hit);
        let side = shape.side_towards(point.ns.dot(-landing.ray.direction));
        if side.traits.irreversible || landing.edges == 1 && !side.traits.is_caster() {
            return None;
        }
        // The camera looks through emitters that are hidden.
        let seen = !(self.lengths.hide_emitters && shape.emitter.is_some());
        scene.materials[side.material as usize].visit(Scatter::<F> {
            caustics: self,
            scene,
            path,
            landing,
            point: &point,
            side,
            seen,
            connections,
            counters,
        })
    }
}

/// A vertex of a light path, for any type of material.
struct Scatter<'a, const F: u32> {
    caustics: &'a Caustics,
    scene: &'a Scene,
    path: &'a mut LightPath,
    landing: Landing<'a>,
    point: &'a SurfacePoint,
    side: &'a Side,
    seen: bool,
    connections: &'a mut Connections,
    counters: &'a mut Counters,
}

impl<const F: u32> Visitor for Scatter<'_, F> {
    type Output = Option<Ray>;

    #[inline]
    fn visit<M: Material>(self, material: &M) -> Option<Ray> {
        let Self { caustics, scene, path, landing, point, side, seen, connections, counters } = self;
        let Landing { ray, hit, edges, u } = landing;
        let Hit { t, primitive, .. } = hit;
        let to_light = -ray.direction;
        let λ = path.λ;
        let frame = side.frame::<F>(point);
        let bsdf = material.at(point, &λ);
        let vertex = Vertex::new(point, primitive, &frame, &bsdf, side, to_light);
        // The density of emitter samples from here by the same specular chain, over the probability that a
        // scattered path chooses the same lobes along it.
        let asked =
            side.traits.has_density && scene.techniques.links.as_ref().is_some_and(|links| links.everywhere);
        let linked = path.chain.filter(|chain| asked && chain.surfaces > 0).map(|chain| {
            let found = density_of(scene, vertex.origin(), to_light, chain, path.end, &λ, counters);
            found.unwrap_or(0.0) * caustics.emitter_samples / chain.chance
        });
        if edges > 1 && seen && side.traits.has_density {
            let lit = LitVertex { vertex: &vertex, to_light, linked };
            caustics.connect(scene, path, lit, u, connections);
        }
        // The next connection is one edge more.
        if edges >= caustics.lengths.max_depth.saturating_sub(1) {
            return None;
        }
        let (lobe, direction) = u.scattering();
        let sample = bsdf.sample(vertex.wo, lobe, direction)?;
        if sample.delta && side.traits.relief {
            return None;
        }
        let to_camera = vertex.to_world(sample.wi);
        let (cos_light, cos_camera) = (point.ng.dot(to_light).abs(), point.ng.dot(to_camera).abs());
        path.chain = path.chain.and_then(|chain| chain.on(side, primitive, vertex.wo, &sample));
        if sample.delta {
            let η2 = sample.eta * sample.eta;
            // A camera path's weight T/(P η²) is a density of ωl, this one's of ωc, and dωl/dωc is the ratio
            // of the cosines times that of the squared indices: this is the shading cosine's place in the
            // estimate.
            let shading = (vertex.wo.z / sample.wi.z).abs();
            path.throughput *= sample.weight * (η2 * shading * cos_camera / cos_light) as f32;
            path.ratio *= η2;
        } else {
            let back = bsdf.evaluate(sample.wi, vertex.wo);
            path.throughput *= back.value * (cos_camera / (sample.pdf * cos_light)) as f32;
            path.ratio *= ratio_at_vertex(
                Leg { pdf: sample.pdf, cos: cos_camera },
                Leg { pdf: back.pdf, cos: cos_light },
            );
            if let Some(linked) = linked {
                path.by_emitter = linked / back.pdf;
            } else if edges == 1 {
                let found = density_of_finding(scene, path.end, &vertex, sample.wi, to_light, t);
                path.by_emitter = found / back.pdf;
            }
        }
        if path.throughput.is_zero() {
            return None;
        }
        if sample.dispersed {
            path.λ.collapse();
        }
        if edges >= caustics.lengths.rr_depth {
            let carried = path.λ.mean(path.throughput) as f64;
            path.throughput *= roulette(carried, edges, sample.delta, u.roulette())?;
        }
        Some(point.ray(to_camera, f64::INFINITY, primitive))
    }
}

/// A vertex that a light path has come to, as the camera may see it.
struct LitVertex<'a, B> {
    vertex: &'a Vertex<'a, B>,
    /// Direction (world) to where the light came from.
    to_light: DVec3,
    /// The density of emitter samples from here by the specular chain that light came by, over the probability
    /// of its lobes, if emitters are sampled so.
    linked: Option<f64>,
}

impl Caustics {
    /// Queues the contribution of a vertex to the camera, with its shadow ray.
    #[inline]
    fn connect<B: Bsdf>(
        &self,
        scene: &Scene,
        path: &LightPath,
        LitVertex { vertex, to_light, linked }: LitVertex<B>,
        u: &Numbers,
        connections: &mut Connections,
    ) {
        let (point, film) = (vertex.point, &scene.sensor.film);
        let Some(view) = scene.sensor.camera.connect(point.p, u.connection()) else { return };
        let place = view.film * DVec2::new(film.size.0 as f64, film.size.1 as f64);
        let chosen = film.pixel_at(place, u.pixel());
        let Some((pixel, filter)) = chosen else { return };
        let scattered = vertex.bsdf.evaluate(vertex.to_local(view.towards), vertex.wo);
        if scattered.value.is_zero() {
            return;
        }
        let cos_light = point.ng.dot(to_light).abs();
        let pixels = f64::from(film.size.0) * f64::from(film.size.1);
        let seen = view.per_area * pixels * point.ng.dot(view.towards).abs();
        let ratio = path.ratio * ratio_at_camera(Leg { pdf: scattered.pdf, cos: cos_light }, seen);
        if ratio == 0.0 {
            // Another technique is infinitely likelier.
            return;
        }
        let by_emitter = linked.map_or(path.by_emitter, |linked| linked / scattered.pdf);
        let shared = power_heuristic_of_ratios(1.0 / ratio, by_emitter / ratio);
        let weight = shared * filter * seen * path.scale / (cos_light * f64::from(self.paths));
        let radiance = path.throughput * path.emitted * scattered.value;
        let ray = point.ray(view.towards, view.distance, vertex.primitive);
        connections.push(path.index, ray, Splat { pixel, λ: path.λ, radiance, weight });
    }
}
