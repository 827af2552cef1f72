//! Path re-use: pixels that see matte surfaces side by side share what their paths find beyond the next matte surface.
//!
//! Paths i = 1…N of neighbouring pixels, made of the same wavelengths, leave matte points xᵢ and arrive at matte points yᵢ. What
//! path j finds from yⱼ on is an estimate Lⱼ of the radiance that leaves yⱼ for all directions alike, so it tells every pixel
//! that sees yⱼ from its own xᵢ. Each of the N points y is a sample of N techniques: that of xₖ has the density, in
//! area about y, pₖ(y) = Gₖ(y)/π with Gₖ(y) = Vₖ(y) cos θₖ |cos ϑₖ| / dₖ²: visibility, the cosines at xₖ and at y, the distance. With the balance heuristic (Veach 1997, §9.2.2)
//! pixel i gathers
//!
//!   Σⱼ (ρᵢ/π) Gᵢ(yⱼ) Lⱼ / Σₖ pₖ(yⱼ)  =  ρᵢ Σⱼ wᵢⱼ Lⱼ,   wᵢⱼ = Gᵢ(yⱼ) / Σₖ Gₖ(yⱼ),
//!
//! where everything but the weights cancels: no weight is above one, and Σᵢ wᵢⱼ = 1, so nothing is gained or lost. One shadow
//! ray buys a pixel the rest of a whole path (Bekaert, Sbert and Halton 2002, "Accelerating Path Tracing by Re-Using Paths"). The
//! price: errors of neighbouring pixels are no longer independent.
//!
//! Mirrors and smooth glass before xᵢ only change what ρᵢ stands for, but then only points that are as many edges from the camera share.
//!
//! What stays with its own path: all light up to yᵢ; paths by surfaces of any other kind; and beyond yᵢ the light that
//! light paths bring as well ([`caustics`](crate::integrator::caustics)), whose weights depend on the pixel.

use super::receivers::Receivers;
use crate::integrator::{CameraPath, Counters};
use crate::math::ray::{Ends, way_between};
use crate::math::{DVec3, Ray, length};
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Edge in pixels of the cells of the film within which pixels share paths.
pub const CELL: u32 = 8;

/// Instead of a number of pixels: a pilot decides, see [`crate::render::reuse`].
pub const AUTO: u32 = 0;

/// How many pixels can share their paths; 1 is none.
pub const PIXELS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

/// Edge in pixels of the squares beyond which no two pixels have anything in common, if `pixels` share.
pub fn correlated_edge(pixels: u32) -> u32 {
    1 << pixels.ilog2().div_ceil(2)
}

/// The pixels of a sample that can share what they find with `pixel`, as far as they are on the film: those of a group of any
/// size in [`PIXELS`] follow one another. Groups are as compact as can be, and lie across in every other sample, so that
/// the same pixels do not always share.
pub fn cell(
    (x, y): (u32, u32),
    sample: u64,
    (width, height): (u32, u32),
) -> impl Iterator<Item = ((u32, u32), u64)> {
    let corner = (x / CELL * CELL, y / CELL * CELL);
    let pixel = move |i: u32| {
        let bits = |i: u32| (i & 1) | (i >> 1 & 2) | (i >> 2 & 4);
        let (x, y) = (bits(i), bits(i >> 1));
        let (x, y) = if sample.is_multiple_of(2) { (x, y) } else { (y, x) };
        (corner.0 + x, corner.1 + y)
    };
    (0..CELL * CELL).map(pixel).filter(move |p| p.0 < width && p.1 < height).map(move |pixel| (pixel, sample))
}

/// What tells apart the group of a pixel's sample from all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    pub cell: (u32, u32),
    pub sample: u64,
    /// Within the cell.
    pub number: u32,
}

impl Group {
    /// The first pixel of the cell.
    pub fn corner(&self) -> (u32, u32) {
        (self.cell.0 * CELL, self.cell.1 * CELL)
    }
}

/// The group of a sample, if there are so many pixels to each.
pub fn group((x, y): (u32, u32), sample: u64, pixels: u32) -> Group {
    let inside = (x % CELL, y % CELL);
    let (i, j) = if sample.is_multiple_of(2) { inside } else { (inside.1, inside.0) };
    let place = (0..3).map(|bit| (i >> bit & 1) << (2 * bit) | (j >> bit & 1) << (2 * bit + 1)).sum::<u32>();
    Group { cell: (x / CELL, y / CELL), sample, number: place / pixels }
}

/// A matte point that a pixel sees, directly or by mirrors and smooth glass.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    pub p: DVec3,
    /// World, unit length, on the side that is seen.
    pub n: DVec3,
    pub primitive: u32,
    /// What becomes of light on its way from the source to the camera.
    pub albedo: Spectrum,
    /// Of the path from the camera, besides the one that ends here. Only receivers with as many share, for what a source is
    /// known to send depends on how many are left.
    pub edges: u32,
}

/// A matte point that a path came to from a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    pub p: DVec3,
    /// World, on the side where the path came from: its shading normal, on whose side it is matte.
    pub n: DVec3,
    /// World, of the surface itself, on either side: areas are its.
    pub ng: DVec3,
    pub primitive: u32,
}

/// What a path has to share.
#[derive(Clone, Copy, Debug)]
pub struct Shared {
    pub receiver: Option<Receiver>,
    pub source: Option<Source>,
    /// The radiance that leaves the source, as far as it is known.
    pub radiance: Spectrum,
}

impl Shared {
    pub const NOTHING: Self = Self { receiver: None, source: None, radiance: Spectrum::ZERO };

    /// What the path's own receiver does to light from its source.
    pub fn albedo(&self) -> Spectrum {
        self.receiver.map_or(Spectrum::ONE, |receiver| receiver.albedo)
    }
}

/// Rays between the receivers and sources of a group, kept for the next.
#[derive(Default)]
pub struct Exchange {
    receivers: Receivers,
    rays: Vec<Ray>,
    shares: Vec<Share>,
    occluded: Vec<bool>,
}

/// What a receiver may have of a source.
struct Share {
    source: usize,
    receiver: usize,
    /// Not yet divided by the sum over receivers.
    weight: f64,
    is_seen: bool,
}

impl Exchange {
    /// Hands on what every path found to all whose receivers see its source.
    pub fn share(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &[Shared],
        counters: &mut Counters,
    ) {
        self.rays.clear();
        self.shares.clear();
        let mut first = 0;
        for receiving in paths.chunk_by_mut(|a, b| a.group == b.group) {
            let group = &shared[first..first + receiving.len()];
            self.receivers.begin(group);
            for (j, path) in group.iter().enumerate() {
                if let Some(source) = path.source.as_ref().filter(|_| !path.radiance.is_zero()) {
                    self.propose(scene, receiving, group, (first, j), source);
                }
            }
            first += group.len();
        }
        self.occluded.clear();
        self.occluded.resize(self.rays.len(), false);
        counters.rays += self.rays.len() as u64;
        counters.shared += self.rays.len() as u64;
        scene.accel.occluded_all(&self.rays, &mut self.occluded);
        let asked = self.shares.iter_mut().filter(|share| !share.is_seen);
        asked.zip(&self.occluded).for_each(|(share, occluded)| share.is_seen = !occluded);
        self.gather(paths, shared);
    }

    /// A share of the source of path j for each receiver of its group that faces it: at once if all of them are in sight, else once the
    /// rays have been traced that ask.
    fn propose(
        &mut self,
        scene: &Scene,
        receiving: &mut [CameraPath],
        group: &[Shared],
        (first, j): (usize, usize),
        source: &Source,
    ) {
        let mut weights = [0.0; 64];
        let facing = self.receivers.weights(j, source, &mut weights);
        // A path knows of itself that it met its source, whatever rounding says.
        let own = 1 << j;
        let in_sight = self.receivers.in_sight(scene, source) | own;
        if facing & own == 0 {
            weights[j] = f64::MIN_POSITIVE;
        }
        let concerned = facing | own;
        if concerned & !in_sight == 0 {
            hand_on(receiving, group, group[j].radiance, bits(concerned).map(|i| (i, weights[i])));
            return;
        }
        for i in bits(concerned) {
            let is_seen = in_sight >> i & 1 == 1;
            let Some(receiver) = group[i].receiver.as_ref() else { continue };
            if !is_seen {
                let way = source.p - receiver.p;
                let distance = length(way);
                let end = way_between(distance, receiver.p, source.p);
                let ray = Ray::leaving(receiver.p, way / distance, end, receiver.primitive);
                self.rays.push(Ray { ends: Ends::OnSurfaces, ..ray });
            }
            self.shares.push(Share { source: first + j, receiver: first + i, weight: weights[i], is_seen });
        }
    }

    fn gather(&self, paths: &mut [CameraPath], shared: &[Shared]) {
        for shares in self.shares.chunk_by(|a, b| a.source == b.source) {
            let seen = shares.iter().filter(|share| share.is_seen);
            let light = shared[shares[0].source].radiance;
            hand_on(paths, shared, light, seen.map(|share| (share.receiver, share.weight)));
        }
    }
}

/// Parts light among receivers in proportion to their weights.
fn hand_on(
    paths: &mut [CameraPath],
    shared: &[Shared],
    light: Spectrum,
    receivers: impl Iterator<Item = (usize, f64)> + Clone,
) {
    let all = 1.0 / receivers.clone().map(|(_, weight)| weight).sum::<f64>();
    for (receiver, weight) in receivers {
        let Some(Receiver { albedo, .. }) = shared[receiver].receiver else { continue };
        paths[receiver].radiance += albedo * light * (weight * all) as f32;
    }
}

/// The places of the ones.
fn bits(mut left: u64) -> impl Iterator<Item = usize> + Clone {
    std::iter::from_fn(move || {
        let first = left.trailing_zeros();
        left &= left.wrapping_sub(1);
        (first < 64).then_some(first as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn groups_are_runs_of_a_cell_and_part_the_film() {
        let film = (21, 13);
        for pixels in PIXELS {
            for sample in [0, 1, 6] {
                let mut seen = BTreeMap::new();
                for corner in (0..3).flat_map(|x| (0..2).map(move |y| (x * CELL, y * CELL))) {
                    let cell: Vec<_> = cell(corner, sample, film).collect();
                    let groups: Vec<Group> = cell.iter().map(|of| group(of.0, of.1, pixels)).collect();
                    let mut distinct = groups.clone();
                    distinct.dedup();
                    let runs = distinct.len();
                    distinct.sort_by_key(|group| group.number);
                    distinct.dedup();
                    assert_eq!(runs, distinct.len(), "a group in two pieces");
                    for (of, group) in cell.iter().zip(groups) {
                        assert_eq!((of.1, group.sample, group.corner()), (sample, sample, corner));
                        assert_eq!(seen.insert(of.0, group), None);
                        let edge = correlated_edge(pixels);
                        let partners =
                            cell.iter().filter(|other| super::group(other.0, sample, pixels) == group);
                        let near = |a: u32, b: u32| a / edge == b / edge;
                        assert!(partners.clone().all(|p| near(p.0.0, of.0.0) && near(p.0.1, of.0.1)));
                        assert!(partners.count() <= pixels as usize);
                    }
                }
                assert_eq!(seen.len(), (film.0 * film.1) as usize);
                let full = seen.values().filter(|group| group.cell == (0, 0) && group.number == 0).count();
                assert_eq!(full, pixels as usize);
            }
        }
    }
}
