//! Paths that begin on a surface whose irradiance is measured.
//!
//! The irradiance E = ∫ L(ω) cos θ dω is π times the radiance that the surface would send back if it were white and
//! scattered by Lambert's law. So light is gathered there as at any matte vertex: by an emitter sample and along the
//! path's own ray, weighed against each other. Light of a point, which no ray meets, counts too; in Mitsuba it does not
//! (mitsuba3 #365).

use super::CameraPath;
use super::arrival::Arrival;
use super::emitter_sampling::{Proposal, SampleCounts, sample_emitter};
use super::vertex::Vertex;
use crate::bsdf::{DiffuseBsdf, Traits};
use crate::emitter::{Choice, Gathers};
use crate::math::Frame;
use crate::math::warp::cosine_hemisphere_pdf;
use crate::sampler::blocks;
use crate::scene::{Features, Scene, Side};
use crate::sensor::Optics;
use crate::shape::{Hit, SurfacePoint};

/// How a path begins on a surface.
pub struct Start {
    /// How its ray was sampled.
    pub arrival: Arrival,
    /// From where light was gathered.
    pub gathers: Gathers,
    /// What an emitter sample found, over the sensor's response.
    pub found: Option<Proposal>,
}

impl Start {
    /// That of a camera's path.
    pub const FROM_CAMERA: Self =
        Self { arrival: Arrival::FROM_CAMERA, gathers: Gathers::EVERYWHERE, found: None };

    /// That of the path, if it begins so; but hidden emitters are seen by nothing that the sensor sends.
    pub fn of(scene: &Scene, hide_emitters: bool, path: &CameraPath) -> Option<Self> {
        let on_surface = scene.sensor.camera.lies_on_surface() && !hide_emitters;
        on_surface.then(|| Self::on_surface(scene, path))
    }

    fn on_surface(scene: &Scene, CameraPath { ray, λ, sampler, .. }: &CameraPath) -> Self {
        let here = Hit { t: 0.0, u: 0.0, v: 0.0, primitive: ray.from };
        let ng = scene.surface::<{ Features::INSTANCES }>(ray, &here).1.ng;
        let n = if ng.dot(ray.direction) < 0.0 { -ng } else { ng };
        let point = SurfacePoint::plain(ray.origin, n, n, ray.start);
        let side = Side::without_material(Traits { has_density: true, one_lobe: true, ..Traits::default() });
        let (frame, white) = (Frame::about(n), DiffuseBsdf::of(λ.ones()));
        let vertex = Vertex::new(&point, ray.from, &frame, &white, &side, n);
        let gathers = vertex.gathers(scene, vertex.wo);
        let choice = Choice::at(gathers.at(point.p));
        let numbers = sampler.block(blocks::vertex(blocks::METER)).emitter_sample();
        let found = sample_emitter(scene, &vertex, &choice, numbers, SampleCounts::ONE, λ, |_, _, _| 0.0);
        let pdf = cosine_hemisphere_pdf(vertex.to_local(ray.direction));
        Self {
            arrival: Arrival { pdf, delta: false, emitter_samples: 1 },
            gathers,
            found: found.map(|(proposal, _)| proposal),
        }
    }
}
