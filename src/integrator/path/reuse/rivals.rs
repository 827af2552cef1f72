//! MIS weights of camera paths, light paths and their connections, for what is found beyond a source.
//!
//! Let v₀ be a matte source, v₁ … vₙ the rest of the path to a point vₙ of an emitter, and S = Σₖ pₖ(v₀) the
//! density of the source; see [`super`]. With the density P of v₁ … vₙ given v₀, three techniques make the
//! path:
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
//! has two techniques itself, emitter samples and those of the BSDF. These divide the share of camera paths
//! as they do without light paths, and the sum of their densities takes the place of the density in c.
//!
//! c = 0 where a lobe without density is on the path, where vₙ₋₁ is a caster, whose light other light paths
//! find, and beyond [`MOST_EDGES`]; r = 0 also where v₁ is not matte, and for n = 1, which is left to emitter
//! samples.

use super::shared::Source;
use crate::bsdf::{Bsdf, Sample};
use crate::emitter::EmitterPoint;
use crate::integrator::caustics::{Leg, ratio_at_vertex};
use crate::integrator::vertex::Vertex;
use crate::math::{DVec3, INV_PI};
use crate::sampler::blocks::SHARED_OF_PATH;
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use std::f64::consts::PI;

/// Most edges of a light path that finds sources, from the emitter to the last of them.
pub const MOST_EDGES: u32 = 15;

const _: () = assert!(MOST_EDGES < SHARED_OF_PATH);

/// The terms c (`by_light`) and r (`connected`) of the MIS weights of some light; see the top of this file.
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

    /// The MIS weight of camera paths whose densities sum to π⁻¹ `density`.
    pub fn camera(&self, density: f64) -> f64 {
        density / (density * (1.0 + self.connected) + PI * self.by_light)
    }

    /// The MIS weight of light paths, if the densities of camera paths sum to π⁻¹ `density`.
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

/// The state of a camera path from its source on.
#[derive(Clone, Copy)]
pub struct Tail {
    /// Product of the factors of c so far; zero if light paths cannot make the path.
    ratio: f64,
    /// p(v₁→v₀) by area; zero if there is no connection.
    to_source: f64,
    edges: u32,
}

impl Tail {
    pub const NONE: Self = Self { ratio: 0.0, to_source: 0.0, edges: 0 };
    pub const BEGINS: Self = Self { ratio: 1.0, ..Self::NONE };

    /// Updates the state at the vertex where the path has arrived.
    pub fn arrive<B: Bsdf>(&mut self, source: Option<&Source>, vertex: &Vertex<B>) {
        if self.edges == MOST_EDGES || vertex.side.traits.irreversible {
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

    /// The factor of c at a vertex, for a direction towards the light (local) that was sampled with this
    /// density.
    pub fn factor<B: Bsdf>(&self, vertex: &Vertex<B>, to_light: DVec3, pdf: f64) -> f64 {
        let ng = vertex.point.ng;
        let cos_light = ng.dot(vertex.to_world(to_light)).abs();
        if self.edges == 0 {
            return cos_light / pdf;
        }
        let back = vertex.bsdf.evaluate(to_light, vertex.wo).pdf;
        let cos_camera = ng.dot(vertex.to_world(vertex.wo)).abs();
        ratio_at_vertex(Leg { pdf: back, cos: cos_camera }, Leg { pdf, cos: cos_light })
    }

    /// Updates the state for the direction that was sampled at a vertex.
    pub fn leave<B: Bsdf>(&mut self, vertex: &Vertex<B>, sample: &Sample) {
        if self.ratio > 0.0 {
            self.ratio *= if sample.delta { 0.0 } else { self.factor(vertex, sample.wi, sample.pdf) };
            self.edges += 1;
        }
    }

    /// The competing densities for light from a point of an emitter, w being the direction from there and
    /// `factor` the last factor of c. `None` if light paths cannot find it.
    pub fn rivals(
        &self,
        scene: &Scene,
        factor: impl FnOnce() -> f64,
        end: EmitterPoint,
        w: DVec3,
    ) -> Option<Rivals> {
        let sources = scene.techniques.light_sources.as_ref().filter(|_| self.ratio > 0.0)?;
        let by_light = self.ratio * factor() * sources.ratio_at_emitter(scene, end, w);
        (by_light > 0.0).then(|| Rivals::new(by_light, self.to_source, sources.paths))
    }
}
