//! How likely light paths make what camera paths find beyond a source.
//!
//! Let v₀ be a matte source, v₁ … vₙ the rest of the way to a point vₙ of an emitter, and S = Σₖ pₖ(v₀) the
//! density of the source; see [`super`]. With the density P of v₁ … vₙ given v₀, three techniques make the
//! way:
//!
//! - a camera path, with S P;
//! - a camera path up to v₀ and a light path up to v₁, connected: each source is with one light path, S p(vₙ
//!   … v₁);
//! - one of M light paths up to v₀, as a source for all: M p(vₙ … v₀).
//!
//! By the balance heuristic their shares are S, S r and c over S (1 + r) + c, where
//!
//!   c = M pₐ(vₙ) p(vₙ→vₙ₋₁) / cosₙ · ∏ ρᵢ (i = n−1 … 1) · cos₀ / p(v₀→v₁),   r = c / (M p(v₁→v₀))
//!
//! with the ρᵢ of [`caustics`](crate::integrator::caustics), and p(v₁→v₀) in area. The edge to the emitter
//! has two techniques itself, emitter samples and those of the BSDF. How they part what is left to camera
//! paths is as without light paths, and their sum takes the place of the density in c.
//!
//! c = 0 where a lobe without density is on the way, where vₙ₋₁ focuses light that other light paths look
//! for, and beyond [`MOST_EDGES`]; r = 0 also where v₁ is not matte, and of n = 1, which is what emitter
//! samples are for.

use super::shared::Source;
use crate::bsdf::{Bsdf, Sample};
use crate::emitter::EmitterPoint;
use crate::integrator::caustics::further;
use crate::integrator::light::Vertex;
use crate::math::{DVec3, INV_PI};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use std::f64::consts::PI;

/// Of a light path that finds sources, from the emitter to the last of them.
pub const MOST_EDGES: u32 = 15;

/// c and r of some light.
#[derive(Clone, Copy, Debug)]
pub struct Rivals {
    pub by_light: f64,
    pub connected: f64,
}

impl Rivals {
    /// From c and the density p(v₁→v₀) in area, zero if there is no connection, with so many light paths.
    pub fn new(by_light: f64, to_source: f64, light_paths: u32) -> Self {
        let connected = if to_source > 0.0 { by_light / (f64::from(light_paths) * to_source) } else { 0.0 };
        Self { by_light, connected }
    }

    /// The share of camera paths whose densities sum to this, as if π were 1.
    pub fn camera(&self, density: f64) -> f64 {
        density / (density * (1.0 + self.connected) + PI * self.by_light)
    }

    /// The share of light paths.
    pub fn light(&self, density: f64) -> f64 {
        1.0 / (1.0 + density * (1.0 + self.connected) / (PI * self.by_light))
    }
}

/// Light at the source of a camera path that light paths find as well.
#[derive(Clone, Copy, Debug)]
pub struct Contested {
    /// The camera path's number.
    pub path: usize,
    pub rivals: Rivals,
    pub light: Spectrum,
}

/// A camera path from its source on.
#[derive(Clone, Copy)]
pub struct Tail {
    /// c as far as it is known; zero if there is nothing to know.
    ratio: f64,
    /// p(v₁→v₀).
    to_source: f64,
    edges: u32,
}

impl Tail {
    pub const NONE: Self = Self { ratio: 0.0, to_source: 0.0, edges: 0 };
    pub const BEGINS: Self = Self { ratio: 1.0, ..Self::NONE };

    /// Takes note of the vertex where the path has arrived.
    pub fn arrive<B: Bsdf>(&mut self, source: Option<&Source>, vertex: &Vertex<B>) {
        if self.edges == MOST_EDGES || vertex.side.traits.one_way {
            // All that is found from here on is longer than what light paths make, or they do not come here.
            self.ratio = 0.0;
        }
        if self.ratio > 0.0
            && self.edges == 1
            && let Some(source) = source
            && vertex.wo.z > 0.0
            && vertex.bsdf.albedo().is_some()
        {
            let way = vertex.point.p - source.p;
            let squared = way.length_squared();
            self.to_source = INV_PI * vertex.wo.z * source.ng.dot(way).abs() / (squared * squared.sqrt());
        }
    }

    /// The factor of c that a vertex brings with a direction towards the light (local) that was sampled with
    /// this density.
    pub fn factor<B: Bsdf>(&self, vertex: &Vertex<B>, to_light: DVec3, pdf: f64) -> f64 {
        let ng = vertex.point.ng;
        let cos_light = ng.dot(vertex.to_world(to_light)).abs();
        if self.edges == 0 {
            return cos_light / pdf;
        }
        let to_camera = vertex.bsdf.evaluate(to_light, vertex.wo).pdf;
        further(to_camera, pdf, ng.dot(vertex.to_world(vertex.wo)).abs(), cos_light)
    }

    /// Goes on from a vertex.
    pub fn leave<B: Bsdf>(&mut self, vertex: &Vertex<B>, sample: &Sample) {
        if self.ratio > 0.0 {
            self.ratio *= if sample.delta { 0.0 } else { self.factor(vertex, sample.wi, sample.pdf) };
            self.edges += 1;
        }
    }

    /// What else finds the light of a point of an emitter, w being the direction from there, if the last
    /// factor of c is this.
    pub fn rivals(
        &self,
        scene: &Scene,
        factor: impl FnOnce() -> f64,
        end: EmitterPoint,
        w: DVec3,
    ) -> Option<Rivals> {
        let sources = scene.light_sources.as_ref().filter(|_| self.ratio > 0.0)?;
        let by_light = self.ratio * factor() * sources.last(scene, end, w);
        (by_light > 0.0).then(|| Rivals::new(by_light, self.to_source, sources.paths))
    }
}
