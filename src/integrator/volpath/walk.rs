//! A path through media, edge by edge.

use super::visibility;
use crate::bsdf::{Bsdf, Sample, Traits};
use crate::emitter::{Choice, Gathers};
use crate::integrator::arrival::{Arrival, Met, environment_along};
use crate::integrator::emitter_sampling::{Proposal, SampleCounts, sample_emitter};
use crate::integrator::lengths::Lengths;
use crate::integrator::meter::Start;
use crate::integrator::roulette::roulette;
use crate::integrator::vertex::Vertex;
use crate::integrator::{CameraPath, Counters, Event};
use crate::math::{DVec3, Frame, Ray};
use crate::medium::{Flight, FlightNumbers, Medium, Shares};
use crate::sampler::{Numbers, blocks};
use crate::scene::{Features, Interface, Scene, Shape, Side};
use crate::shape::{Hit, SurfacePoint};
use crate::spectrum::Spectrum;

/// The state of a path between two vertices.
pub struct Walk<'a> {
    lengths: Lengths,
    scene: &'a Scene,
    path: &'a mut CameraPath,
    counters: &'a mut Counters,
    pub radiance: Spectrum,
    throughput: Spectrum,
    /// The square of the relative index the path is in.
    eta2: f64,
    ray: Ray,
    medium: Option<&'a Medium>,
    /// How often the path was scattered; passing straight through a surface does not count.
    depth: u32,
    /// Where the path was last scattered (world), which the densities of emitters ask for.
    from: DVec3,
    /// How its direction was sampled there.
    arrival: Arrival,
    /// From where light was gathered there.
    gathers: Gathers,
    /// Distance since, across surfaces that it passed straight.
    travelled: f64,
}

impl<'a> Walk<'a> {
    pub fn from_camera(
        lengths: Lengths,
        scene: &'a Scene,
        path: &'a mut CameraPath,
        counters: &'a mut Counters,
    ) -> Self {
        let ray = path.ray;
        Self {
            lengths,
            scene,
            counters,
            radiance: Spectrum::ZERO,
            throughput: path.λ.ones(),
            eta2: 1.0,
            ray,
            medium: scene.sensor.medium.as_deref(),
            depth: 0,
            from: ray.origin,
            arrival: Arrival::FROM_CAMERA,
            gathers: Gathers::EVERYWHERE,
            travelled: 0.0,
            path,
        }
    }

    /// Gathers light at the surface on which the path begins, if it does.
    pub fn begin<const F: u32>(&mut self) {
        let Some(Start { arrival, gathers, found }) =
            Start::of(self.scene, self.lengths.hide_emitters, self.path)
        else {
            return;
        };
        (self.arrival, self.gathers) = (arrival, gathers);
        if let Some(proposal) = found {
            self.receive::<F>(proposal, self.medium, blocks::METER);
        }
    }

    /// Follows the ray, which is edge number `edge`, from 1 on, to the next vertex and chooses the next ray;
    /// `None` if the path ends.
    pub fn step<const F: u32>(&mut self, edge: u32) -> Option<()> {
        let u = self.path.sampler.block(blocks::vertex(edge));
        self.counters.rays += 1;
        let hit = self.scene.accel.closest(&self.ray);
        let length = hit.map_or(self.ray.end, |hit| hit.t);
        if let Some(medium) = self.medium {
            let mut numbers = FlightNumbers::after(u.flight(), &self.path.sampler, blocks::flight(edge));
            let segment = Ray { end: length, ..self.ray };
            match medium.fly(&segment, self.throughput, &self.path.λ, &mut numbers) {
                Flight::Scattered(t, weight) => {
                    self.throughput *= weight;
                    return self.within::<F>(medium, t, &u, edge);
                }
                Flight::Through(weight) => {
                    if !medium.scatters && !self.path.covered && !self.is_last() {
                        // What only absorbs covers as much as it takes: by what each lane carries, as scattering
                        // would have it, so it does not matter how the way is divided. The number ends no path on
                        // this edge, for roulette is for paths that have been scattered, by what covers.
                        let comes_through = Shares::of(self.throughput, &self.path.λ).mean(weight);
                        self.path.covered = u.roulette() >= f64::from(comes_through);
                    }
                    self.throughput *= weight;
                }
            }
            if hit.is_none() && self.ray.end.is_finite() {
                // Beyond the camera's `far_clip` nothing is seen, but the medium goes on.
                let beyond = Ray { origin: self.ray.at(self.ray.end), end: f64::INFINITY, ..self.ray };
                self.throughput *= medium.transmittance(&beyond, &self.path.λ, &mut numbers);
            }
            if self.throughput.is_zero() {
                return None;
            }
        }
        self.travelled += length;
        match hit {
            Some(hit) => self.at_surface::<F>(hit, &u, edge),
            None => {
                self.surroundings::<F>();
                None
            }
        }
    }

    /// Whether no path is longer than one with a vertex here.
    fn is_last(&self) -> bool {
        self.depth + 1 >= self.lengths.max_depth
    }

    /// Light from outside the scene.
    fn surroundings<const F: u32>(&mut self) {
        let hidden = self.lengths.hide_emitters && self.depth == 0;
        if F & Features::ENVIRONMENT != 0 && !hidden {
            let ray = Ray { origin: self.from, ..self.ray };
            self.radiance += self.throughput
                * environment_along(self.scene, &ray, &self.gathers, &self.arrival, &self.path.λ);
        }
    }

    /// A vertex within a medium, at distance t along the ray.
    fn within<const F: u32>(&mut self, medium: &'a Medium, t: f64, u: &Numbers, edge: u32) -> Option<()> {
        let p = self.ray.at(t);
        self.log(t, None, p);
        // As in Mitsuba, paths that end for their length have scattered on surfaces, but not in media.
        self.path.covered |= !self.is_last();
        if self.throughput.is_zero() || self.is_last() {
            return None;
        }
        // The phase function is a BSDF about the direction to where the path came from.
        let wo = -self.ray.direction;
        let (point, frame) = (SurfacePoint::plain(p, wo, wo, 0.0), Frame::about(wo));
        let traits = Traits { has_density: true, transmits: true, ..Traits::default() };
        let side = Side::without_material(traits);
        let phase = medium.phase.at(p);
        let vertex = Vertex::new(&point, Ray::FREE, &frame, &phase, &side, wo);
        let gathers = Gathers::EVERYWHERE;
        if medium.samples_emitters {
            self.gather::<F, _>(&vertex, &gathers, None, u, edge);
        }
        let (lobe, direction) = u.scattering();
        let sample = phase.sample(vertex.wo, lobe, direction)?;
        let arrival = Arrival { pdf: sample.pdf, delta: !medium.samples_emitters, emitter_samples: 1 };
        let onward = Ray::free(p, vertex.to_world(sample.wi));
        self.scatter::<F>(&sample, arrival, gathers, onward, u)
    }

    /// A vertex on a surface.
    fn at_surface<const F: u32>(&mut self, hit: Hit, u: &Numbers, edge: u32) -> Option<()> {
        let (shape, point) = self.scene.surface::<F>(&self.ray, &hit);
        if let Some(emitter) = shape.emitter {
            if self.lengths.hide_emitters && self.depth == 0 {
                self.pass(shape, &point, &hit);
                return Some(());
            }
            self.path.covered |= !self.lengths.hide_emitters;
            self.emission(shape, emitter as usize, &point);
        }
        self.log(hit.t, Some(hit.primitive), point.p);
        let wo = -self.ray.direction;
        let side = shape.side_towards(point.ns.dot(wo));
        let last = self.is_last();
        if last && !side.traits.has_null {
            self.path.covered = true;
            return None;
        }
        let frame = side.frame::<F>(&point);
        let λ = self.path.λ;
        let bsdf = self.scene.materials[side.material as usize].at(&point, &λ);
        let vertex = Vertex::new(&point, hit.primitive, &frame, &bsdf, side, wo);
        let gathers = vertex.gathers(self.scene, vertex.wo);
        if side.traits.has_density && !last {
            self.gather::<F, _>(&vertex, &gathers, shape.interface.as_deref(), u, edge);
        }
        let (lobe, direction) = u.scattering_if(side.traits.has_density);
        let sample = bsdf.sample(vertex.wo, lobe, direction);
        self.path.covered |= !sample.is_some_and(|sample| sample.null);
        let sample = sample?;
        if sample.null {
            self.throughput *= sample.weight;
            self.pass(shape, &point, &hit);
            return (!self.throughput.is_zero()).then_some(());
        }
        if last {
            return None;
        }
        let arrival = Arrival { pdf: sample.pdf, delta: sample.delta, emitter_samples: 1 };
        let onward = point.ray(vertex.to_world(sample.wi), f64::INFINITY, hit.primitive);
        if let Some(interface) = shape.interface.as_deref() {
            self.medium = interface.towards(onward.direction.dot(point.ng));
        }
        self.scatter::<F>(&sample, arrival, gathers, onward, u)
    }

    /// Goes straight on through a surface, as in Mitsuba beyond the camera's `far_clip` too.
    fn pass(&mut self, shape: &'a Shape, point: &SurfacePoint, hit: &Hit) {
        let w = self.ray.direction;
        if let Some(interface) = shape.interface.as_deref() {
            self.medium = interface.towards(w.dot(point.ng));
        }
        self.ray = point.ray(w, f64::INFINITY, hit.primitive);
    }

    /// Light that an emitting surface sends along the ray.
    fn emission(&mut self, shape: &Shape, index: usize, point: &SurfacePoint) {
        let ray = &Ray { origin: self.from, ..self.ray };
        let met = Met { ray, t: self.travelled, shape, point, emitter: index };
        let choice = Choice::at(self.gathers.at(self.from));
        self.radiance += self.throughput * met.weighted(self.scene, &choice, &self.arrival, &self.path.λ);
    }

    /// Takes an emitter sample from a vertex, on a surface that may part media.
    fn gather<const F: u32, B: Bsdf>(
        &mut self,
        vertex: &Vertex<B>,
        gathers: &Gathers,
        interface: Option<&'a Interface>,
        u: &Numbers,
        edge: u32,
    ) {
        let choice = Choice::at(gathers.at(vertex.point.p));
        let (numbers, λ) = (u.emitter_sample(), &self.path.λ);
        let found =
            sample_emitter(self.scene, vertex, &choice, numbers, SampleCounts::ONE, λ, |_, _, _| 0.0);
        let Some((proposal, _)) = found else { return };
        let medium = match interface {
            Some(interface) => interface.towards(proposal.ray.direction.dot(vertex.point.ng)),
            None => self.medium,
        };
        self.receive::<F>(proposal, medium, edge);
    }

    /// Adds as much of an emitter sample as comes through a medium and what else lies between.
    fn receive<const F: u32>(&mut self, proposal: Proposal, medium: Option<&'a Medium>, edge: u32) {
        let ray = proposal.ray;
        let mut numbers = FlightNumbers::independent(&self.path.sampler, blocks::shadow_flight(edge));
        let visible =
            visibility::between::<F>(self.scene, ray, medium, &self.path.λ, &mut numbers, self.counters);
        if !visible.is_zero() {
            self.radiance += self.throughput * proposal.radiance(self.scene, &self.path.λ) * visible;
        }
    }

    /// Sets out in a new direction.
    fn scatter<const F: u32>(
        &mut self,
        sample: &Sample,
        arrival: Arrival,
        gathers: Gathers,
        onward: Ray,
        u: &Numbers,
    ) -> Option<()> {
        self.throughput *= sample.weight;
        self.eta2 *= sample.eta * sample.eta;
        self.depth += 1;
        if self.throughput.is_zero() {
            return None;
        }
        if F & Features::DISPERSION != 0 && sample.dispersed {
            self.path.λ.collapse();
        }
        if self.depth >= self.lengths.rr_depth {
            let carried = f64::from(self.path.λ.peak(self.throughput)) * self.eta2;
            self.throughput *= roulette(carried, self.depth, sample.delta, u.roulette())?;
        }
        (self.ray, self.from, self.travelled) = (onward, onward.origin, 0.0);
        (self.arrival, self.gathers) = (arrival, gathers);
        Some(())
    }

    fn log(&mut self, t: f64, primitive: Option<u32>, p: DVec3) {
        if let Some(log) = &mut self.counters.log {
            log.push(Event { t, primitive, p, throughput: self.throughput, radiance: self.radiance });
        }
    }
}
