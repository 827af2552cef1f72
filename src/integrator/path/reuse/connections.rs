//! Connections between sources of camera paths and sources of light paths.

use super::light_sources::{LightSource, LightSources};
use super::rivals::{Contested, MOST_EDGES, Rivals};
use super::shared::{Shared, Source, trace_shadow_rays};
use crate::integrator::Counters;
use crate::math::{INV_PI, Ray};
use crate::scene::Scene;

/// Buffers for connections, kept for the next stream.
#[derive(Default)]
pub struct Connections {
    rays: Vec<Ray>,
    proposed: Vec<Contested>,
    occluded: Vec<bool>,
}

impl Connections {
    /// Queues connections between the matte source of each path of a group and the sources of one of the
    /// group's light paths. `first` is the number of the group's first path.
    pub fn propose(
        &mut self,
        light_sources: &LightSources,
        max_depth: u32,
        first: usize,
        group: &[Shared],
        lit: &[LightSource],
    ) {
        for (j, path) in group.iter().enumerate() {
            let (Some(receiver), Some(source)) = (&path.receiver, &path.source) else { continue };
            if source.lobes.is_some() {
                continue;
            }
            let of = j as u32 % light_sources.paths;
            let longest = MOST_EDGES.min(max_depth.saturating_sub(receiver.edges + 2));
            for lit in lit.iter().filter(|lit| lit.owner.light_path == of && lit.edges < longest) {
                if let Some(rivals) = rivals(source, lit, light_sources.paths) {
                    // With the scale s of one of M light paths, a connection brings ρ M s L p(v₀→v₁). It counts r
                    // times as much as what a camera path finds, whose MIS weight is applied later by
                    // `Rivals::camera`. In r = c / (M p(v₁→v₀)) c is that of the light path times p(v₁→v₀) /
                    // p(v₀→v₁), so M and both densities cancel.
                    let scale = lit.scale * lit.rivals.by_light;
                    let light = source.albedo * lit.radiance * scale as f32;
                    self.rays.push(source.ray_to(&lit.source));
                    self.proposed.push(Contested { path: first + j, rivals, light });
                }
            }
        }
    }

    /// Traces the rays of all queued connections, adds the light of those that are unoccluded to `contested`,
    /// and empties the queue.
    pub fn resolve(&mut self, scene: &Scene, contested: &mut Vec<Contested>, counters: &mut Counters) {
        let Self { rays, proposed, occluded } = self;
        trace_shadow_rays(scene, rays, occluded, counters);
        contested.extend(proposed.drain(..).zip(occluded).filter(|(_, is)| !**is).map(|(of, _)| of));
        rays.clear();
    }
}

/// The competing densities of a path from the source of a camera path by that of a light path. `None` unless
/// both face each other.
fn rivals(source: &Source, lit: &LightSource, light_paths: u32) -> Option<Rivals> {
    let way = lit.source.p - source.p;
    let squared = way.length_squared();
    let w = way / squared.sqrt();
    let (cos, cos_lit) = (source.n.dot(w), -lit.source.n.dot(w));
    if !(cos > 0.0 && cos_lit > 0.0) {
        return None;
    }
    // The densities, in area, with which either would be sampled from the other.
    let to_lit = INV_PI * cos * lit.source.ng.dot(w).abs() / squared;
    let to_source = INV_PI * cos_lit * source.ng.dot(w).abs() / squared;
    let by_light = lit.rivals.by_light * to_source / to_lit;
    (by_light > 0.0 && by_light.is_finite()).then(|| Rivals::new(by_light, to_source, light_paths))
}
