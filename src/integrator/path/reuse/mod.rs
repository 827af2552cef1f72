//! Path re-use: pixels that see surfaces side by side share what their paths find beyond the next surface.
//!
//! Paths i = 1…N of neighbouring pixels, made of the same wavelengths, leave points xᵢ, the *receivers*, and
//! arrive at points yᵢ, the *sources*. What path j finds from yⱼ on is an estimate for every other pixel,
//! too, whose xᵢ sees yⱼ. Each of the N points y is a sample of N techniques: that of xₖ has the density, in
//! area about y, pₖ(y) = Vₖ(y) p(ωₖ) |cos ϑₖ| / dₖ²: visibility, the density with which xₖ scatters towards
//! y, the cosine at y, the distance. It is zero where path k would end on the way because nothing of its throughput
//! is left: a black rough receiver scatters in all directions, and finds nothing in any.
//!
//! **Matte sources.** An estimate Lⱼ of the radiance that leaves yⱼ is one for all directions alike. With the
//! balance heuristic (Veach 1997, §9.2.2) pixel i gathers
//!
//!   Σⱼ f(ωᵢ) |cos θᵢ| Vᵢ |cos ϑᵢ| / dᵢ² · Lⱼ / Σₖ pₖ(yⱼ).
//!
//! If all receivers are matte, pₖ = Gₖ/π with Gₖ = Vₖ cos θₖ |cos ϑₖ| / dₖ², and this is ρᵢ Σⱼ Lⱼ Gᵢ(yⱼ) / Σₖ
//! Gₖ(yⱼ): no weight is above one, and those of a source sum to one, so nothing is gained or lost.
//!
//! **Rough sources** scatter differently towards each receiver, so what is shared begins one edge further:
//! path j goes on from yⱼ in direction ωⱼ, and Lⱼ is what comes back along it from the next surface,
//! excluding what that surface emits (its MIS weight against emitter sampling depends on xⱼ), and only if
//! that surface has a density: specular chains compete with other techniques too. Then Lⱼ has the factor
//! f(yⱼ: ωⱼ → xᵢ) |cos ωⱼ|, and pₖ the factor p(yⱼ: xₖ → ωⱼ).
//!
//! One shadow ray buys a pixel the rest of a whole path (Bekaert, Sbert and Halton 2002, "Accelerating Path
//! Tracing by Re-Using Paths"). The price: errors of neighbouring pixels are no longer independent.
//!
//! Specular vertices before xᵢ only scale its light; only receivers the same number of edges from the camera
//! share.
//!
//! **Light paths** may find more sources for a group, and light that matte ones send: `light_sources.rs` says
//! why, `rivals.rs` derives the weights.
//!
//! What is not shared: all light up to yᵢ, and to a rough yᵢ; paths by surfaces of any other kind; and beyond
//! yᵢ the light that light paths find as well ([`caustics`](crate::integrator::caustics)), whose MIS weights
//! depend on the pixel. These find none for pixels that see xᵢ by mirrors or glass, which share all of it.

mod connections;
mod contribution;
mod exchange;
mod light_path;
mod light_sources;
mod lobes;
mod pending;
mod receivers;
mod rivals;
mod shared;

use crate::sampler::SampleId;
use crate::spectrum::ColorMode;
pub use exchange::Exchange;
pub use light_sources::LightSources;
pub use rivals::{Contested, Rivals, Tail};
pub use shared::Shared;

/// Edge in pixels of the cells of the film within which pixels share paths.
pub const CELL: u32 = 8;

/// Instead of a number of pixels: a pilot decides, see [`crate::render::plan::reuse`].
pub const AUTO: u32 = 0;

/// How many pixels can share their paths; 1 is none.
pub const PIXELS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

/// Edge in pixels of the squares beyond which no two pixels have anything in common, if `pixels` share: in
/// spectra all pixels of a cell have the same wavelengths.
pub fn correlated_edge(pixels: u32, mode: ColorMode) -> u32 {
    if pixels > 1 && mode == ColorMode::Spectral { CELL } else { 1 << pixels.ilog2().div_ceil(2) }
}

/// The pixels of a sample that can share what they find with `pixel`, as far as they are on the film: those
/// of a group of any size in [`PIXELS`] follow one another. Groups are as compact as can be, and lie across
/// in every other sample, so that the same pixels do not always share.
pub fn cell((x, y): (u32, u32), sample: u64, (width, height): (u32, u32)) -> impl Iterator<Item = SampleId> {
    let corner = (x / CELL * CELL, y / CELL * CELL);
    let pixel = move |i: u32| {
        let bits = |i: u32| (i & 1) | (i >> 1 & 2) | (i >> 2 & 4);
        let (x, y) = (bits(i), bits(i >> 1));
        let (x, y) = if sample.is_multiple_of(2) { (x, y) } else { (y, x) };
        (corner.0 + x, corner.1 + y)
    };
    (0..CELL * CELL)
        .map(pixel)
        .filter(move |p| p.0 < width && p.1 < height)
        .map(move |pixel| SampleId { pixel, sample })
}

/// The identity of the group that a pixel's sample belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupId {
    pub cell: (u32, u32),
    pub sample: u64,
    /// Number of the group within the cell.
    pub number: u32,
}

impl GroupId {
    /// The first pixel of the cell.
    pub fn corner(&self) -> (u32, u32) {
        (self.cell.0 * CELL, self.cell.1 * CELL)
    }
}

/// The group of a pixel's sample, if groups have so many pixels.
pub fn group(SampleId { pixel: (x, y), sample }: SampleId, pixels: u32) -> GroupId {
    let inside = (x % CELL, y % CELL);
    let (i, j) = if sample.is_multiple_of(2) { inside } else { (inside.1, inside.0) };
    let place = (0..3).map(|bit| (i >> bit & 1) << (2 * bit) | (j >> bit & 1) << (2 * bit + 1)).sum::<u32>();
    GroupId { cell: (x / CELL, y / CELL), sample, number: place / pixels }
}

#[cfg(test)]
mod tests;
