//! Camera paths in streams that take each step together.

use super::chain::ChainSince;
use super::escapes::Escapes;
use super::reuse::{Exchange, Shared, Tail};
use super::shadows::{Destination, Shadows};
use super::{FEW_EMITTERS, Path};
use crate::emitter::Gathers;
use crate::integrator::arrival::Arrival;
use crate::integrator::meter::Start;
use crate::integrator::wavefront::{STREAM, Wavefront};
use crate::integrator::{CameraPath, Counters};
use crate::sampler::{ManyNumbers, PAIRS, blocks};
use crate::scene::{Features, Scene};
use crate::sensor::Optics;
use crate::spectrum::Spectrum;

/// The state of a camera path between two vertices.
#[derive(Clone, Copy)]
pub struct State {
    pub throughput: Spectrum,
    /// The square of the relative index the path is in: radiance inside glass is larger by it, and roulette
    /// must not take that for importance.
    pub eta2: f64,
    pub arrival: Arrival,
    /// Number of vertices so far: 0 before and at the first. The ray is edge `depth` + 1.
    pub depth: u32,
    /// Whether the ray still goes straight from the camera.
    pub direct_view: bool,
    /// Whether the path has only been through lobes without density, such as mirrors and smooth glass.
    pub specular_so_far: bool,
    /// Vertices from the first with a density on, that one included.
    pub vertices_since_rough: u32,
    /// The product of the factors of r at the vertices so far: the density with which light paths make this
    /// path, over that of its own; see [`caustics`](crate::integrator::caustics). 0 if they cannot.
    pub light_ratio: f64,
    /// Whether the last vertex is on a caster, at which light paths that end here would have been aimed.
    pub from_caster: bool,
    /// What is found from here on is shared with other pixels; the throughput begins anew.
    pub shares: bool,
    /// How likely light paths make what is shared.
    pub tail: Tail,
}

impl State {
    /// At the camera, but for the throughput, [`Wavelengths::ones`](crate::spectrum::Wavelengths::ones).
    const START: Self = Self {
        throughput: Spectrum::ZERO,
        eta2: 1.0,
        arrival: Arrival::FROM_CAMERA,
        depth: 0,
        direct_view: true,
        specular_so_far: true,
        vertices_since_rough: 0,
        light_ratio: 1.0,
        from_caster: false,
        shares: false,
        tail: Tail::NONE,
    };

    /// What light from here on is multiplied with for the path's own pixel.
    #[inline(always)]
    pub fn own_throughput<const F: u32>(&self, shared: &Shared) -> Spectrum {
        if F & Features::REUSE != 0 && self.shares { self.throughput * shared.own } else { self.throughput }
    }

    /// The throughput for light that is found from here on, and whether it goes to all pixels that share or to
    /// the path's own. Light from a caster (`casts`), which light paths find too, they share only where
    /// [`Shared::receives_casters`].
    #[inline(always)]
    pub fn delivers<const F: u32>(&self, scene: &Scene, shared: &Shared, casts: bool) -> (Spectrum, bool) {
        let shares = F & Features::REUSE != 0 && self.shares && (!casts || shared.receives_casters(scene));
        (if shares { self.throughput } else { self.own_throughput::<F>(shared) }, shares)
    }
}

/// One path of a stream, and what belongs to it.
pub struct InFlight<'a> {
    /// Its place in the stream.
    pub index: usize,
    pub path: &'a mut CameraPath,
    pub state: &'a mut State,
    /// How the last vertex gathered light; not kept where no choice of an emitter depends on it.
    pub gathers: &'a mut Gathers,
    pub shared: &'a mut Shared,
    pub chain: &'a mut ChainSince,
}

/// Light that a step has found, but for what it waits for.
#[derive(Default)]
pub struct Pending {
    /// Waits for shadow rays.
    pub shadows: Shadows,
    /// Waits for memory.
    pub escapes: Escapes,
}

/// Buffers of a stream of paths, kept for the next.
#[derive(Default)]
struct Stream {
    states: Vec<State>,
    gathers: Vec<Gathers>,
    wavefront: Wavefront,
    numbers: ManyNumbers<STREAM>,
    pending: Pending,
    shared: Vec<Shared>,
    chains: Vec<ChainSince>,
    exchange: Exchange,
}

impl Path {
    /// Estimates the radiance along camera rays.
    ///
    /// In streams of `STREAM`, all paths take a step together: their rays are traced, then their vertices are
    /// processed one after another, then the shadow rays of the vertices are traced; no path depends on the
    /// others.
    pub fn trace<const F: u32>(&self, scene: &Scene, paths: &mut [CameraPath], counters: &mut Counters) {
        if self.lengths.max_depth == 0 {
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
            let Stream { exchange, shared, pending, .. } = &mut stream;
            let contested = &mut pending.shadows.contested;
            exchange.share(scene, self.lengths.max_depth, now, shared, contested, counters);
            paths = later;
        }
    }

    /// How many pairs of numbers [`Scatter`](super::scatter::Scatter) needs at the end of edge number
    /// `edges`: two for a place on an emitter and a direction; a third for more digits of a choice between
    /// many emitters and for a choice between lobes; a fourth for roulette and for a choice between links.
    fn pairs(&self, scene: &Scene, edges: u32) -> usize {
        if self.roulette.may_have_begun(edges) || scene.techniques.links.is_some() {
            PAIRS
        } else if scene.emitters.list.len() > FEW_EMITTERS || scene.several_lobes {
            3
        } else {
            2
        }
    }

    /// Gathers light at a meter on which all paths begin. For all features at once: other sensors do not pay for it.
    #[inline(never)]
    fn begin_on_surface(
        &self,
        scene: &Scene,
        paths: &[CameraPath],
        states: &mut [State],
        gathers: &mut [Gathers],
        shadows: &mut Shadows,
    ) {
        for (index, path) in paths.iter().enumerate() {
            let Some(start) = Start::of(scene, self.lengths.hide_emitters, path) else { continue };
            let state = &mut states[index];
            (state.arrival, gathers[index]) = (start.arrival, start.gathers);
            if let Some(proposal) = start.found {
                shadows.push(Destination { path: index, shares: false }, state.throughput, proposal);
            }
        }
    }

    fn trace_stream<const F: u32>(
        &self,
        scene: &Scene,
        paths: &mut [CameraPath],
        Stream { states, gathers, wavefront, numbers, pending, shared, chains, .. }: &mut Stream,
        counters: &mut Counters,
    ) {
        states.clear();
        states.extend(paths.iter().map(|path| State { throughput: path.λ.ones(), ..State::START }));
        gathers.resize(paths.len(), Gathers::EVERYWHERE);
        if F & Features::REUSE != 0 {
            shared.clear();
        }
        shared.resize(paths.len(), Shared::NOTHING);
        if F & Features::CAUSTICS != 0 {
            chains.clear();
        }
        chains.resize(paths.len(), ChainSince::Nothing);
        wavefront.begin(paths.iter().map(|path| path.ray).enumerate());
        if scene.sensor.camera.lies_on_surface() {
            self.begin_on_surface(scene, paths, states, gathers, &mut pending.shadows);
        }
        // Surroundings in view cover everything.
        let surrounded = !self.lengths.hide_emitters && scene.emitters.environment.is_some();
        paths.iter_mut().for_each(|path| path.covered = surrounded);
        for edges in 1.. {
            let going = wavefront.trace(scene, counters);
            if going.is_empty() {
                break;
            }
            let sampler = |i: usize| (&paths[going[i]].sampler, blocks::vertex(states[going[i]].depth + 1));
            numbers.fill(going.len(), self.pairs(scene, edges), sampler);
            wavefront.advance(|arrived| {
                let (index, u) = (arrived.path, numbers.of(arrived.place));
                if pending.shadows.rays.len() > Shadows::MANY {
                    pending.shadows.resolve(scene, paths, shared, counters);
                }
                let flight = InFlight {
                    index,
                    path: &mut paths[index],
                    state: &mut states[index],
                    gathers: &mut gathers[index],
                    shared: &mut shared[index],
                    chain: &mut chains[index],
                };
                self.step::<F>(scene, flight, arrived, u, pending, counters)
            });
            if F & Features::ENVIRONMENT != 0 {
                pending.escapes.resolve(scene, paths, gathers, shared);
            }
            pending.shadows.resolve(scene, paths, shared, counters);
        }
    }
}
