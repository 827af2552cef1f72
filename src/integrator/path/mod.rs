//! Unidirectional path tracing with direct light by multiple importance sampling.

pub mod reuse;

use super::caustics;
use super::light::{self, Vertex, power_heuristic, power_heuristic_of_three};
use super::{AnyIntegrator, CameraPath, Counters, Event};
use crate::bsdf::{Bsdf, Material, Visitor};
use crate::emitter::DirectSample;
use crate::math::{DVec3, Ray};
use crate::sampler::{FIRST_VERTEX, FURTHER_EMITTER_SAMPLES, ManyNumbers, Numbers};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::{Features, Scene, Shape, Side};
use crate::shape::{Hit, SurfacePoint};
use crate::spectrum::{Spectrum, Wavelengths};
use reuse::{Exchange, Receiver, Shared, Source};

pub const NAME: &str = "path";
pub const ABOUT: &str = "Path tracing: all light that a camera path can find, unbiased.";
pub const EXAMPLES: &[&str] = &[
    r#"<integrator type="path"/>"#,
    r#"<integrator type="path"><integer name="max_depth" value="8"/><integer name="rr_depth" value="5"/>
        <integer name="emitter_samples" value="4"/></integrator>"#,
];

/// No path goes on beyond this many vertices. Roulette ends paths long before, except where nothing is ever
/// absorbed; such paths are counted and reported.
pub const MAX_VERTICES: u32 = 1 << 20;

/// The settings, with Mitsuba's meaning of each.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Edges of the longest path: 1 sees emitters, 2 direct light, and so on.
    pub max_depth: u32,
    /// Edges before Russian roulette begins.
    pub rr_depth: u32,
    /// Emitters are not seen directly.
    pub hide_emitters: bool,
    /// Emitter samples at every vertex; Mitsuba takes one.
    pub emitter_samples: u32,
    /// Light paths to a camera path, where there are caustics; see [`caustics`]. By default a pilot decides.
    pub light_paths: Option<f64>,
    /// How many neighbouring pixels share what their paths find; see [`reuse`].
    pub reuse: u32,
}

/// How many light paths to a camera path there can be.
pub const LIGHT_PATHS: std::ops::RangeInclusive<f64> = 0.0..=64.0;

impl Default for Path {
    fn default() -> Self {
        Self {
            max_depth: u32::MAX,
            rr_depth: 5,
            hide_emitters: false,
            emitter_samples: 1,
            light_paths: None,
            reuse: 1,
        }
    }
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    let about = "edges of the longest path; −1 means no limit";
    let max_depth = params.integer("max_depth", -1, -1..=i64::from(u32::MAX), about)?;
    let about = "edges before Russian roulette begins";
    let rr_depth = params.integer("rr_depth", 5, 1..=i64::from(u32::MAX), about)? as u32;
    let hide_emitters = params.boolean("hide_emitters", false, "emitters are not seen directly")?;
    let about = "emitter samples at every vertex (an extension)";
    let emitter_samples = params.integer("emitter_samples", 1, 1..=1024, about)? as u32;
    let max_depth = u32::try_from(max_depth).unwrap_or(u32::MAX);
    let about =
        "light paths to a camera path, where there are caustics; 0 leaves all to camera paths (an extension)";
    let light_paths = params.optional_float("light_paths", about)?;
    if light_paths.is_some_and(|share| !LIGHT_PATHS.contains(&share)) {
        let help = format!("expected {} to {}", LIGHT_PATHS.start(), LIGHT_PATHS.end());
        return Err(params.error("light_paths", "no such share", help));
    }
    let about = "neighbouring pixels that share what their paths find: 1, 2, 4, 8 or 16 (an extension)";
    let reuse = params.integer("reuse", 1, 1..=16, about)? as u32;
    if !reuse::PIXELS.contains(&reuse) {
        return Err(params.error("reuse", "no such number of pixels", "expected 1, 2, 4, 8 or 16"));
    }
    Ok(AnyIntegrator::Path(Path { max_depth, rr_depth, hide_emitters, emitter_samples, light_paths, reuse }))
}

/// How the path came to where it is: what its next emitter is to be weighed with.
#[derive(Clone, Copy)]
pub struct Arrival {
    /// The density of the direction, in sr⁻¹.
    pub pdf: f64,
    /// The direction could not have been found by sampling an emitter.
    pub delta: bool,
}

/// How many camera paths are traced together: enough to fill vector registers most of the time, few enough for the
/// nearest cache.
const STREAM: usize = 64;

/// A path on its way.
#[derive(Clone, Copy)]
struct State {
    throughput: Spectrum,
    /// The square of the relative index the path is in: radiance inside glass is larger by it, and roulette
    /// must not take that for importance.
    eta2: f64,
    arrival: Arrival,
    /// Edges behind it.
    depth: u32,
    /// Whether the ray still goes straight from the camera.
    direct_view: bool,
    /// The factors of how much likelier light paths make this path, and whether they would begin at the last vertex;
    /// see [`caustics`].
    light_ratio: f64,
    from_caster: bool,
    /// What is found from here on is shared with other pixels; the throughput begins at the source.
    shares: bool,
}

impl State {
    const START: Self = Self {
        throughput: Spectrum::ONE,
        eta2: 1.0,
        arrival: Arrival { pdf: 1.0, delta: true },
        depth: 0,
        direct_view: true,
        light_ratio: 1.0,
        from_caster: false,
        shares: false,
    };
}

/// Light that waits to be tested for visibility, the path it belongs to, and whether it is shared.
#[derive(Default)]
struct Shadows {
    rays: Vec<Ray>,
    light: Vec<(usize, bool, Spectrum)>,
    occluded: Vec<bool>,
}

impl Shadows {
    /// More than this need not wait.
    const MANY: usize = 4 * STREAM;

    fn push(&mut self, (path, shares): (usize, bool), ray: Ray, light: Spectrum) {
        self.rays.push(ray);
        self.light.push((path, shares, light));
    }

    /// Adds what arrives, in the order in which it was pushed.
    fn resolve(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &mut [Shared],
        counters: &mut Counters,
    ) {
        counters.rays += self.rays.len() as u64;
        self.occluded.resize(self.rays.len(), false);
        scene.accel.occluded_all(&self.rays, &mut self.occluded);
        for ((path, shares, light), occluded) in self.light.drain(..).zip(&self.occluded) {
            match occluded {
                true => {}
                false if shares => shared[path].radiance += light,
                false => paths[path].radiance += light,
            }
        }
        self.rays.clear();
    }
}

/// What a stream of paths needs on its way, kept for the next.
#[derive(Default)]
struct Stream {
    states: Vec<State>,
    /// The paths that still go on, with their rays side by side.
    alive: Vec<usize>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    numbers: ManyNumbers<STREAM>,
    shadows: Shadows,
    shared: Vec<Shared>,
    exchange: Exchange,
}

impl Path {
    /// Estimates the radiance along camera rays.
    ///
    /// In streams of `STREAM`, all paths take a step together: their rays are traced, then their vertices are looked at one after another,
    /// then the light that the vertices ask for is tested for visibility. Rays that lie side by side can share
    /// vector registers, and the steps of neighbours overlap in the processor; no path knows of the others.
    pub fn trace<const F: u32>(&self, scene: &Scene, paths: &mut [CameraPath], counters: &mut Counters) {
        if self.max_depth == 0 {
            return;
        }
        let mut stream = Stream::default();
        if F & Features::REUSE == 0 || self.reuse == 1 {
            for paths in paths.chunks_mut(STREAM) {
                self.trace_stream::<F>(scene, paths, &mut stream, counters);
            }
            return;
        }
        let mut paths = paths;
        while !paths.is_empty() {
            // As many groups as fit.
            let mut end = 0;
            for group in paths.chunk_by(|a, b| a.group == b.group) {
                if end + group.len() > STREAM {
                    break;
                }
                end += group.len();
            }
            let (now, later) = paths.split_at_mut(end);
            self.trace_stream::<F>(scene, now, &mut stream, counters);
            stream.exchange.share(scene, now, &stream.shared, counters);
            paths = later;
        }
    }

    fn trace_stream<const F: u32>(
        &self,
        scene: &Scene,
        paths: &mut [CameraPath],
        Stream { states, alive, rays, hits, numbers, shadows, shared, .. }: &mut Stream,
        counters: &mut Counters,
    ) {
        states.clear();
        states.resize(paths.len(), State::START);
        shared.clear();
        shared.resize(paths.len(), Shared::NOTHING);
        alive.clear();
        alive.extend(0..paths.len());
        rays.clear();
        rays.extend(paths.iter().map(|path| path.ray));
        hits.resize(paths.len(), None);
        while !alive.is_empty() {
            let count = alive.len();
            counters.rays += count as u64;
            scene.accel.closest_all(rays, hits);
            numbers.fill(count, |i| (&paths[alive[i]].sampler, FIRST_VERTEX + states[alive[i]].depth));
            let mut kept = 0;
            for i in 0..count {
                let index = alive[i];
                let (path, state) = (&mut paths[index], &mut states[index]);
                let onward = self.step::<F>(
                    scene,
                    (index, path, state, &mut shared[index]),
                    (&rays[i], hits[i]),
                    numbers.of(i),
                    shadows,
                    counters,
                );
                if let Some(ray) = onward {
                    (alive[kept], rays[kept]) = (index, ray);
                    kept += 1;
                }
                if shadows.rays.len() > Shadows::MANY {
                    shadows.resolve(scene, paths, shared, counters);
                }
            }
            alive.truncate(kept);
            rays.truncate(kept);
            shadows.resolve(scene, paths, shared, counters);
        }
    }

    /// What happens where a ray has arrived; the ray with which the path goes on.
    #[inline(always)]
    fn step<const F: u32>(
        &self,
        scene: &Scene,
        (index, path, state, shared): (usize, &mut CameraPath, &mut State, &mut Shared),
        (ray, hit): (&Ray, Option<Hit>),
        u: Numbers,
        shadows: &mut Shadows,
        counters: &mut Counters,
    ) -> Option<Ray> {
        let λ = &mut path.λ;
        let Some(hit) = hit else {
            if F & Features::ENVIRONMENT != 0 && !(self.hide_emitters && state.direct_view) {
                let light = environment(scene, ray, state.arrival, self.emitter_samples, λ);
                let found = if state.shares { &mut shared.radiance } else { &mut path.radiance };
                *found += state.throughput * light;
                path.covered |= scene.emitters.environment.is_some();
            }
            return None;
        };
        let (shape, point) = if F & Features::TEXTURES != 0 {
            scene.surface::<true>(ray, &hit)
        } else {
            scene.surface::<false>(ray, &hit)
        };
        if let Some(emitter) = shape.emitter {
            if self.hide_emitters && state.depth == 0 {
                // Light paths do not see the camera through an emitter.
                state.light_ratio = 0.0;
                return Some(Ray::leaving(point.p, ray.direction, ray.end - hit.t, hit.primitive));
            }
            path.covered |= !self.hide_emitters;
            let entry = &scene.emitters.list[emitter as usize];
            let emitted = entry.emitter.surface_radiance(&point, -ray.direction, λ);
            if !emitted.is_zero() {
                let by_emitter = if state.arrival.delta {
                    0.0
                } else {
                    let pdf = entry.emitter.surface_pdf(&shape.geometry, ray, hit.t, &point);
                    let chosen = scene.emitters.probability(emitter as usize);
                    chosen * pdf * self.emitter_samples as f64 / state.arrival.pdf
                };
                let by_light_path = match &scene.caustics {
                    Some(caustics) if F & Features::CAUSTICS != 0 && state.from_caster => {
                        let end = (emitter as usize, point.p, point.ng);
                        state.light_ratio * caustics.last(scene, end, -ray.direction)
                    }
                    _ => 0.0,
                };
                let weight = power_heuristic_of_three(by_emitter, by_light_path) as f32;
                let light = state.throughput * emitted * weight;
                if !state.shares {
                    path.radiance += light;
                } else if F & Features::CAUSTICS != 0 && scene.caustics.is_some() && state.from_caster {
                    path.radiance += shared.albedo() * light;
                } else {
                    shared.radiance += light;
                }
            }
        }
        if let Some(log) = &mut counters.log {
            let (throughput, radiance) = (state.throughput, path.radiance);
            log.push(Event { hit, p: point.p, throughput, radiance, nm: λ.nm[0] });
        }
        if state.depth + 1 >= self.max_depth {
            // The surroundings would have been seen at last, and they cover everything.
            path.covered |= !self.hide_emitters && scene.emitters.environment.is_some();
            return None;
        }
        let side = side_towards(shape, point.ns.dot(-ray.direction));
        let onward = scene.materials[side.material as usize].visit(Scatter::<F> {
            settings: self,
            scene,
            index,
            path,
            state,
            shared,
            wo: -ray.direction,
            primitive: hit.primitive,
            point: &point,
            side,
            u,
            shadows,
        })?;
        if state.depth >= MAX_VERTICES {
            counters.cut += 1;
            return None;
        }
        Some(onward)
    }
}

/// Scattering at a vertex, for a material still to be named.
struct Scatter<'a, const F: u32> {
    settings: &'a Path,
    scene: &'a Scene,
    index: usize,
    path: &'a mut CameraPath,
    state: &'a mut State,
    shared: &'a mut Shared,
    /// World, towards where the path came from.
    wo: DVec3,
    primitive: u32,
    point: &'a SurfacePoint,
    side: Side,
    u: Numbers,
    shadows: &'a mut Shadows,
}

impl<const F: u32> Visitor for Scatter<'_, F> {
    type Output = Option<Ray>;

    /// Asks for direct light and finds the ray with which the path goes on.
    #[inline]
    fn visit<M: Material>(self, material: &M) -> Option<Ray> {
        let Self { settings, scene, index, path, state, shared, wo, primitive, point, side, u, shadows } =
            self;
        let (λ, sampler) = (&mut path.λ, &path.sampler);
        let frame = point.frame(F & Features::ANISOTROPY != 0 && side.traits.anisotropic);
        let bsdf = material.at(point, λ);
        let mut vertex = Vertex { point, primitive, frame: &frame, bsdf: &bsdf, wo: DVec3::ZERO, side };
        vertex.wo = vertex.to_local(wo);
        if F & Features::REUSE != 0 && settings.reuse > 1 && vertex.wo.z > 0.0 {
            match (state.depth, bsdf.albedo()) {
                (0, Some(albedo)) if settings.rr_depth > 1 && !albedo.is_zero() => {
                    let n = vertex.to_world(DVec3::Z);
                    shared.receiver = Some(Receiver { p: point.p, n, primitive, albedo });
                }
                (1, Some(_)) if shared.receiver.is_some() => {
                    shared.source = Some(Source { p: point.p, n: vertex.to_world(DVec3::Z) });
                    (state.throughput, state.shares) = (Spectrum::ONE, true);
                }
                _ => {}
            }
        }
        if side.traits.smooth {
            let counts = (settings.emitter_samples as f64, 1.0);
            let focuses = state.depth > 0 && side.traits.focuses();
            let ratio = if focuses { state.light_ratio } else { 0.0 };
            let light_paths = |emitter: usize, light: &DirectSample| match &scene.caustics {
                Some(caustics) if F & Features::CAUSTICS != 0 && ratio > 0.0 && light.n != DVec3::ZERO => {
                    let end = (emitter, point.p + light.wi * light.distance, light.n);
                    let to_camera = bsdf.evaluate(vertex.to_local(light.wi), vertex.wo).pdf;
                    let (cos_light, cos_camera) = (point.ng.dot(light.wi).abs(), point.ng.dot(wo).abs());
                    let ratio = ratio * caustics::further(to_camera, 1.0, cos_camera, cos_light);
                    ratio * caustics.last(scene, end, -light.wi)
                }
                _ => 0.0,
            };
            let sample = |u: &Numbers| {
                light::sample_emitter(scene, &vertex, u.one(4), u.pair(0), counts, λ, light_paths)
            };
            // What light paths make as well is weighed for this pixel alone.
            let alone = F & Features::CAUSTICS != 0 && focuses && scene.caustics.is_some();
            let shares = state.shares && !alone;
            let throughput =
                if state.shares && !shares { state.throughput * shared.albedo() } else { state.throughput };
            let owner = (index, shares);
            if let Some(light) = sample(&u) {
                shadows.push(owner, light.ray, throughput * light.radiance);
            }
            for further in 1..settings.emitter_samples {
                let u = sampler.block(FURTHER_EMITTER_SAMPLES + state.depth * 1024 + further);
                if let Some(light) = sample(&u) {
                    shadows.push(owner, light.ray, throughput * light.radiance);
                }
            }
        }
        let sample = bsdf.sample(vertex.wo, u.one(5), u.pair(1));
        path.covered |= !sample.is_some_and(|sample| sample.null);
        let sample = sample?;
        if F & Features::CAUSTICS != 0 && state.light_ratio > 0.0 {
            let to_light = vertex.to_world(sample.wi);
            let (cos_light, cos_camera) = (point.ng.dot(to_light).abs(), point.ng.dot(wo).abs());
            state.light_ratio *= if sample.delta && side.traits.one_way {
                0.0
            } else if state.depth == 0 {
                let seen = scene.pixels_per_area(&path.ray, point.p) * cos_camera;
                caustics::first(sample.delta, sample.pdf, cos_light, seen)
            } else if sample.delta {
                1.0 / (sample.eta * sample.eta)
            } else {
                let to_camera = bsdf.evaluate(sample.wi, vertex.wo).pdf;
                caustics::further(to_camera, sample.pdf, cos_camera, cos_light)
            };
            state.from_caster = state.depth > 0 && side.traits.focuses();
        }
        state.throughput *= sample.weight;
        state.eta2 *= sample.eta * sample.eta;
        state.arrival = Arrival { pdf: sample.pdf, delta: sample.delta };
        state.direct_view &= sample.null;
        state.depth += 1;
        if state.throughput.is_zero() {
            return None;
        }
        let onward = Ray::leaving(point.p, vertex.to_world(sample.wi), f64::INFINITY, primitive);
        drop(bsdf);
        if F & Features::DISPERSION != 0 && sample.dispersed {
            λ.collapse();
        }
        if state.depth >= settings.rr_depth {
            // The largest lane: a red path between red walls must not be punished for its other lanes. What a lossless
            // path has lost to rounding is no loss: in a thousand reflections it would end one path in thousands.
            let throughput = if state.shares { state.throughput * shared.albedo() } else { state.throughput };
            let survival = λ.peak(throughput) as f64 * state.eta2;
            let rounding = 4.0 * state.depth as f64 * f32::EPSILON as f64;
            if survival < 1.0 - rounding {
                if u.one(6) >= survival {
                    return None;
                }
                state.throughput *= (1.0 / survival) as f32;
            }
        }
        Some(onward)
    }
}

/// What the side of a surface wears on which a direction with this cosine lies.
#[inline]
pub fn side_towards(shape: &Shape, cos: f64) -> Side {
    shape.sides[usize::from(cos < 0.0)]
}

/// Light from the environment along a ray that met nothing.
#[inline]
pub fn environment(
    scene: &Scene,
    ray: &Ray,
    arrival: Arrival,
    emitter_samples: u32,
    λ: &Wavelengths,
) -> Spectrum {
    let Some(index) = scene.emitters.environment else { return Spectrum::ZERO };
    let emitter = &scene.emitters.list[index].emitter;
    let Some((radiance, pdf)) = emitter.distant_radiance(ray.direction, λ) else { return Spectrum::ZERO };
    if arrival.delta {
        return radiance;
    }
    let rival = scene.emitters.probability(index) * pdf * emitter_samples as f64;
    radiance * power_heuristic(arrival.pdf, rival) as f32
}

#[cfg(test)]
mod tests;
