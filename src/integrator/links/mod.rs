//! Emitter samples through glass and by mirrors.
//!
//! A shadow ray ends at glass, and cannot follow light that a mirror reflects, so such light is left to paths
//! that happen to hit the emitter, and to light paths; but where the surface is itself seen through glass or
//! in a mirror, light paths cannot be connected with the camera. A specular chain leads from the surface to
//! the sampled point of the emitter, and [`Link`] finds it: manifold next-event estimation (Hanika, Droske &
//! Fascione 2015), for interfaces that only refract, and at most one mirror that is flat or a ball
//! (`element.rs`). Through a ball of glass there may be several chains, and all of them are found
//! (`glass_ball.rs`). Chains through glass, by a mirror and through a ball are techniques that have no path in
//! common.
//!
//! **The density.** A point y of the emitter with density pₐ(y) by area stands for the direction ω in which
//! the chain to it leaves the vertex, with the density p(ω) = pₐ(y) |∂y/∂ω|: the derivatives along the chain
//! give the area |∂y⊥/∂ω| across the ray, and the emitter is hit at an angle, so p(ω) = pₐ(y) |∂y⊥/∂ω| / cos
//! θ_y. Points are sampled as if for the vertex, for its image in the mirror, or for the middle of the ball:
//! the straight line's density of directions p′ gives pₐ = p′ cos θ′_y / d². The mirror and the ball are
//! chosen with probabilities that depend on where the vertex is.
//!
//! **The weights.** There may be other chains to y, with other interfaces or other bends; they are left to
//! paths that scatter into them. So when such a path has left a vertex by a lobe with a density, followed
//! specular surfaces and hit the emitter, the links between vertex and emitter are computed again: only if
//! this very chain is among them could an emitter sample have made the path. Then its weight is the power
//! heuristic's, of p(ω) and the density of scattering times the probability of the lobe chosen at each
//! surface. What is found depends on the two points and the mirror or ball alone, so both sides agree; and so
//! do light paths, the third technique (see [`caustics`](super::caustics)), which look for the link as soon
//! as they meet a rough surface.

mod bent;
mod chain;
mod element;
mod elements;
mod glass_ball;
mod link;
mod recognition;
mod surfaces;

use super::Counters;
use super::emitter_sampling::Proposal;
use super::mis::power_heuristic_of_ratios;
use super::vertex::Vertex;
use crate::bsdf::{AnyMaterial, Bsdf};
use crate::emitter::{AnyEmitter, Choice, EmitterPoint, Gathers, Radiance};
use crate::math::bounds::union;
use crate::math::ray::{free_way, position_error};
use crate::math::{Chosen, DVec3, Origin, Ray, length};
use crate::sampler::EmitterNumbers;
use crate::scene::{Scene, Shape};
use crate::shape::{Geometry, SurfacePoint};
use crate::spectrum::{ColorMode, Wavelengths};
pub use chain::SpecularChain;
use element::Element;
use elements::Elements;
pub use link::Link;
use link::Search;

/// Directions closer than this are those of the same link: Newton's method repeats one far more closely, and
/// other links are farther apart.
const SAME: f64 = 1e-6;

/// At which vertices emitters are sampled through glass and by mirrors, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkPolicy {
    /// Pilots of the scene decide between the last three.
    Auto,
    Never,
    /// Where no light path can be connected with the camera.
    Unaided,
    Everywhere,
    /// Where no light path can be connected with the camera, guided by photons of light paths; see
    /// [`guide`](super::guide).
    Guided,
}

impl LinkPolicy {
    /// Each by its name in scene files.
    pub const ALL: [(&str, Self); 5] = [
        ("auto", Self::Auto),
        ("never", Self::Never),
        ("unaided", Self::Unaided),
        ("everywhere", Self::Everywhere),
        ("guided", Self::Guided),
    ];
}

/// How an emitter sample is connected.
#[derive(Clone, Copy)]
pub struct Connector<'a> {
    /// The mirror or the ball of glass that it leads by; `None` for panes and other glass alone.
    by: Option<&'a Element>,
    /// Probability of choosing it.
    chance: f64,
}

impl Connector<'_> {
    const THROUGH: Self = Self { by: None, chance: 1.0 };

    /// The point as from which emitters are sampled, for a vertex at p.
    fn seen_from(&self, p: DVec3) -> Option<DVec3> {
        self.by.map_or(Some(p), |element| element.image(p))
    }
}

/// The specular shapes that links may lead by.
#[derive(Debug)]
pub struct Links {
    /// Boxes around shapes that refract; where there are many, one around all.
    glass: Vec<(DVec3, DVec3)>,
    mirrors: Elements,
    glass_balls: Elements,
    /// Whether all vertices sample links, not only those where light paths cannot help.
    pub everywhere: bool,
}

impl Links {
    /// `None` without specular shapes or without area emitters.
    pub fn of(shapes: &[Shape], materials: &[AnyMaterial], mode: ColorMode) -> Option<Self> {
        const FEW: usize = 8;
        let refracting = shapes.iter().filter(|shape| shape.refracts());
        let mut glass: Vec<_> = refracting.map(|shape| shape.geometry.bounds()).collect();
        if glass.len() > FEW {
            let all = glass.iter().copied().reduce(union);
            glass = all.into_iter().collect();
        }
        let [mirrors, glass_balls] = Elements::of(shapes, materials, mode);
        let shining = shapes.iter().any(|shape| shape.emitter.is_some());
        let something = !glass.is_empty() || !mirrors.is_empty();
        (something && shining).then_some(Self { glass, mirrors, glass_balls, everywhere: false })
    }

    /// The techniques for emitter samples at a point: through glass alone, through a ball, and by a mirror,
    /// the ball and the mirror chosen by a number in [0, 1).
    pub fn connectors(&self, p: DVec3, choice: f64) -> impl Iterator<Item = Connector<'_>> {
        let through = (!self.glass.is_empty()).then_some(Connector::THROUGH);
        let one = [&self.glass_balls, &self.mirrors].map(|elements| elements.choose(p, choice));
        through.into_iter().chain(one.into_iter().flatten())
    }

    /// The technique whose links from a point lead by such surfaces, if there is one.
    fn connector(&self, p: DVec3, chain: &SpecularChain) -> Option<Connector<'_>> {
        for elements in [&self.glass_balls, &self.mirrors] {
            if let Some(index) = elements.of_chain(chain) {
                return Some(elements.connector(p, index)).filter(|connector| connector.chance > 0.0);
            }
        }
        (chain.reflections == 0).then_some(Connector::THROUGH)
    }

    /// Whether glass may lie between a point and the one at `distance` from it in unit direction `w`.
    pub fn may_be_between(&self, p: DVec3, w: DVec3, distance: f64) -> bool {
        // For a direction along a side, 0 · ∞ must not arise.
        let inverse = w.map(|w| 1.0 / if w == 0.0 { f64::MIN_POSITIVE } else { w });
        self.glass.iter().any(|(lo, hi)| {
            let (a, b) = ((*lo - p) * inverse, (*hi - p) * inverse);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            enter <= leave && enter <= distance && leave >= 0.0
        })
    }
}

/// The density with which one emitter sample at a vertex makes a direction that leads by specular surfaces to
/// a point of an emitter; `None` if the sampler would find a different path there, or no path.
pub fn density_of(
    scene: &Scene,
    from: Origin,
    direction: DVec3,
    chain: SpecularChain,
    EmitterPoint { emitter, p, n }: EmitterPoint,
    λ: &Wavelengths,
    counters: &mut Counters,
) -> Option<f64> {
    let entry = &scene.emitters.list[emitter];
    let geometry = &scene.shapes[entry.shape? as usize].geometry;
    let connector = scene.techniques.links.as_ref()?.connector(from.p, &chain)?;
    let seen_from = connector.seen_from(from.p)?;
    let towards = p - seen_from;
    let distance = length(towards);
    let straight = Ray::leaving(seen_from, towards / distance, distance, from.primitive);
    if straight.direction.dot(n) >= 0.0 {
        return None;
    }
    let to = straight.at(free_way(distance, geometry.point_error() + position_error(seen_from)));
    // Of fewer surfaces it would be another path, even in the same direction: glass does not bend light behind
    // the last of them that it has in common with this one.
    let search = Search::new(scene, from, to, connector.by, chain.surfaces as usize, counters)
        .filter(|search| search.surfaces() == chain.surfaces)?;
    let is_it = |link: &Link| length(link.direction - direction) < SAME && link.last.direction.dot(n) < 0.0;
    let link = search.links(λ, counters).find(is_it)?;
    let pdf = entry.emitter.surface_pdf(geometry, &straight, distance, &SurfacePoint::plain(p, n, n, 0.0));
    let chosen =
        Choice::at(Gathers::EVERYWHERE.at(from.p)).probability(&scene.emitters, emitter) * connector.chance;
    Some(chosen * density(pdf, straight.direction, distance, &link, n))
}

/// p(ω) from p′, the straight line (direction and distance), the link, and the emitter's normal.
fn density(straight_pdf: f64, straight: DVec3, distance: f64, link: &Link, n: DVec3) -> f64 {
    straight_pdf * (n.dot(straight) / (n.dot(link.last.direction) * distance * distance)).abs() * link.spread
}

/// One emitter sample by specular chains.
pub struct LinkSample<'a> {
    pub connector: Connector<'a>,
    pub numbers: EmitterNumbers,
    /// How many are taken at the vertex.
    pub count: f64,
    /// Most surfaces of a chain.
    pub most: usize,
}

/// Takes an emitter sample by specular chains: passes the contribution of each link, with its MIS weight, to `found`, up
/// to visibility behind the last surface. `light_paths(link, pdf, end)` is the density of light paths over that of
/// scattering, for the whole path by the link to that point of the emitter, where scattering has the density `pdf`.
pub fn sample_by_links<B: Bsdf>(
    scene: &Scene,
    vertex: &Vertex<B>,
    LinkSample { connector, numbers, count, most }: LinkSample,
    λ: &Wavelengths,
    light_paths: impl Fn(&Link, f64, EmitterPoint) -> f64,
    counters: &mut Counters,
    mut found: impl FnMut(Proposal),
) -> Option<()> {
    let Chosen { index, probability, rest: u } =
        Choice::at(Gathers::EVERYWHERE.at(vertex.point.p)).sample(&scene.emitters, numbers)?;
    let entry = &scene.emitters.list[index];
    if !matches!(entry.emitter, AnyEmitter::Area(_)) {
        return None;
    }
    let shape = entry.shape.map(|i| &scene.shapes[i as usize].geometry);
    let from = vertex.origin();
    let seen_from = connector.seen_from(from.p)?;
    let light = entry.emitter.sample(shape, seen_from, DVec3::ZERO, u, λ)?;
    let Radiance::Known(radiance) = light.radiance else { return None };
    if radiance.is_zero() {
        return None;
    }
    let to = seen_from + light.wi * light.distance;
    let search = Search::new(scene, from, to, connector.by, most, counters)?;
    for link in search.links(λ, counters) {
        let cos = -link.last.direction.dot(light.n);
        if cos <= 0.0 {
            continue;
        }
        // The ray misses the sampled point a little, and may meet the emitter's surface earlier by this.
        let error = shape.map_or(0.0, Geometry::point_error) + position_error(link.last.origin);
        let early = 2.0 * link.miss / cos + 4.0 * error;
        let scattered = vertex.bsdf.evaluate(vertex.wo, vertex.to_local(link.direction));
        let chance = probability * connector.chance;
        let pdf = density(light.pdf, light.wi, light.distance, &link, light.n) * chance * count;
        if scattered.value.is_zero() || pdf.is_nan() || pdf <= 0.0 {
            continue;
        }
        let scattering = scattered.pdf * link.chance;
        let end = EmitterPoint { emitter: index, p: to, n: light.n };
        let by_light_path = scattering * light_paths(&link, scattered.pdf, end);
        let weight = power_heuristic_of_ratios(scattering / pdf, by_light_path / pdf);
        found(Proposal {
            ray: Ray { end: link.last.end - early, ..link.last },
            radiance: scattered.value * link.transmittance * radiance * (weight / pdf) as f32,
            environment: None,
        });
    }
    Some(())
}

#[cfg(test)]
mod tests;
