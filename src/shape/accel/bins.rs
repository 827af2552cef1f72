//! Division of boxes into two groups.
//!
//! Their centres go into bins along each axis, and the plane between two bins is taken that costs rays least
//! by the surface area heuristic (Wald 2007, "On Fast Construction of SAH-Based Bounding Volume Hierarchies",
//! section 3). Size is an axis too: so the walls of a room are separated from what stands in it, whose boxes
//! they would enlarge.

use super::collapse::LEAF;
use glam::Vec4;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Fewest boxes that are processed by several threads.
const MANY: usize = 1 << 16;

/// Most boxes that are binned coarsely.
const FEW: usize = 512;

/// Size is an axis where the largest box is more than so many times as large as the smallest.
const VARIED: f32 = 4.0;

/// Most boxes of a tree whose memory does not count.
const SMALL: usize = 1 << 17;

/// What a group costs: its area, for each block that it needs, and for places of its last one that stay empty.
#[derive(Clone, Copy)]
pub struct Pricing {
    /// The cost of an empty place, in blocks.
    empty: f32,
}

/// Boxes, binned by their [`coordinates`].
#[derive(Clone)]
struct Bins<const BINS: usize, const AXES: usize> {
    bounds: [[Aabb; BINS]; AXES],
    counts: [[u32; BINS]; AXES],
}

/// The map from coordinates to bins.
#[derive(Clone, Copy)]
struct Scale<const BINS: usize> {
    origin: Vec4,
    factor: Vec4,
}

/// A plane between two bins.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    /// The first bin behind it.
    bin: usize,
    bounds: [Aabb; 2],
}

/// Where some boxes are.
#[derive(Clone, Copy)]
pub struct Place {
    /// The box around all.
    pub bounds: Aabb,
    extent: Extent,
}

/// The least and greatest [`coordinates`] of some boxes.
#[derive(Clone, Copy)]
struct Extent {
    lo: Vec4,
    hi: Vec4,
}

/// Sorts at least two boxes, which are at `place`, into two groups, and their items likewise. Returns the size of
/// the first and where both are. Neither group is empty.
pub fn divide(boxes: &mut [Aabb], items: &mut [u32], place: &Place, pricing: Pricing) -> (usize, [Place; 2]) {
    match boxes.len() {
        0..=16 => divide_by::<8, 3>(boxes, items, place, pricing),
        17..=FEW => divide_by::<16, 3>(boxes, items, place, pricing),
        _ if place.extent.hi.w > VARIED * place.extent.lo.w => {
            divide_by::<32, 4>(boxes, items, place, pricing)
        }
        _ => divide_by::<32, 3>(boxes, items, place, pricing),
    }
}

fn divide_by<const BINS: usize, const AXES: usize>(
    boxes: &mut [Aabb],
    items: &mut [u32],
    place: &Place,
    pricing: Pricing,
) -> (usize, [Place; 2]) {
    let scale = Scale::<BINS>::new(place.extent);
    let best = Bins::<BINS, AXES>::new(boxes, scale).best(pricing);
    let Some(plane) = best else {
        // All centres are in one place.
        let (one, other) = boxes.split_at(boxes.len() / 2);
        return (one.len(), [Place::of(one), Place::of(other)]);
    };
    // Without a branch that could be mispredicted: each box in turn is swapped with the first that is behind
    // the plane.
    let first_behind = Vec4::splat(WHOLE + plane.bin as f32);
    let mut extents = [Extent::NOTHING; 2];
    let mut at = 0;
    for i in 0..boxes.len() {
        let coordinates = coordinates::<AXES>(&boxes[i]);
        let bin = Vec4::splat(scale.whole(coordinates).to_array()[plane.axis]);
        let before = bin.cmplt(first_behind);
        // What is not of a group is infinitely far on the side that does not count.
        let far = Vec4::select(before, Vec4::NEG_INFINITY, Vec4::INFINITY);
        extents[0].add(coordinates.max(far), coordinates.min(-far));
        extents[1].add(coordinates.max(-far), coordinates.min(far));
        boxes.swap(i, at);
        items.swap(i, at);
        at += (before.bitmask() & 1) as usize;
    }
    let [before, behind] = plane.bounds;
    let places = [Place { bounds: before, extent: extents[0] }, Place { bounds: behind, extent: extents[1] }];
    (at, places)
}

impl Place {
    /// Of no boxes.
    pub const NOTHING: Self = Self { bounds: Aabb::INVALID, extent: Extent::NOTHING };

    pub fn of(boxes: &[Aabb]) -> Self {
        let mut extent = Extent::NOTHING;
        boxes.iter().map(coordinates::<4>).for_each(|at| extent.add(at, at));
        Self { bounds: around(boxes), extent }
    }

    /// Of the boxes of both.
    pub fn and(mut self, other: &Self) -> Self {
        self.extent.add(other.extent.lo, other.extent.hi);
        Self { bounds: self.bounds.union(&other.bounds), extent: self.extent }
    }
}

/// The box around all.
pub fn around(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::empty(), |all, next| all.union(next))
}

/// Twice the centre, and the longest edge if that is an axis, else zero.
#[inline(always)]
fn coordinates<const AXES: usize>(aabb: &Aabb) -> Vec4 {
    let size = if AXES == 4 { (aabb.max - aabb.min).max_element() } else { 0.0 };
    (aabb.min + aabb.max).extend(size)
}

impl Extent {
    const NOTHING: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    fn add(&mut self, lo: Vec4, hi: Vec4) {
        *self = Self { lo: self.lo.min(lo), hi: self.hi.max(hi) };
    }
}

/// 2²³: next to it there are only whole numbers, whose bits end with what was added.
const WHOLE: f32 = 8388608.0;

impl<const BINS: usize> Scale<BINS> {
    fn new(Extent { lo, hi }: Extent) -> Self {
        // An axis without extent gets infinity or NaN.
        Self { origin: lo, factor: Vec4::splat((BINS - 1) as f32) / (hi - lo) }
    }

    /// [`WHOLE`] and the bin on each axis.
    #[inline(always)]
    fn whole(&self, coordinates: Vec4) -> Vec4 {
        (coordinates - self.origin) * self.factor + Vec4::splat(WHOLE)
    }

    #[inline(always)]
    fn bins<const AXES: usize>(&self, aabb: &Aabb) -> [usize; 4] {
        // Infinity and NaN end with zeros.
        self.whole(coordinates::<AXES>(aabb)).to_array().map(|x| x.to_bits() as usize % BINS)
    }
}

impl<const BINS: usize, const AXES: usize> Bins<BINS, AXES> {
    const EMPTY: Self = Self { bounds: [[Aabb::INVALID; BINS]; AXES], counts: [[0; BINS]; AXES] };

    fn new(boxes: &[Aabb], scale: Scale<BINS>) -> Self {
        if boxes.len() < MANY {
            Self::of(boxes, scale)
        } else {
            let parts = boxes.par_chunks(MANY / 4).map(|boxes| Self::of(boxes, scale));
            parts.reduce(|| Self::EMPTY, |one, other| one.and(&other))
        }
    }

    fn of(boxes: &[Aabb], scale: Scale<BINS>) -> Self {
        let mut bins = Self::EMPTY;
        let (pairs, last) = boxes.as_chunks();
        if boxes.len() > FEW {
            // Neighbours often go into the same bin, and the second would wait for the first.
            let mut others = Self::EMPTY;
            for [one, other] in pairs {
                bins.add(one, scale);
                others.add(other, scale);
            }
            last.iter().for_each(|one| bins.add(one, scale));
            bins.and(&others)
        } else {
            boxes.iter().for_each(|one| bins.add(one, scale));
            bins
        }
    }

    #[inline(always)]
    fn add(&mut self, aabb: &Aabb, scale: Scale<BINS>) {
        for (axis, bin) in scale.bins::<AXES>(aabb).into_iter().enumerate().take(AXES) {
            self.bounds[axis][bin] = self.bounds[axis][bin].union(aabb);
            self.counts[axis][bin] += 1;
        }
    }

    fn and(mut self, other: &Self) -> Self {
        for axis in 0..AXES {
            for bin in 0..BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(&other.bounds[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The plane of least cost, the first one of several; none if one bin has all.
    fn best(&self, pricing: Pricing) -> Option<Plane> {
        let (mut least, mut best) = (f32::INFINITY, None);
        for axis in 0..AXES {
            let (bounds, counts) = (&self.bounds[axis], &self.counts[axis]);
            // Of all bins from one on.
            let mut behind = [0.0; BINS];
            let mut all = (Aabb::INVALID, 0);
            for bin in (1..BINS).rev() {
                all = (all.0.union(&bounds[bin]), all.1 + counts[bin]);
                behind[bin] = pricing.cost(all);
            }
            let mut before = (Aabb::INVALID, 0);
            for bin in 1..BINS {
                before = (before.0.union(&bounds[bin - 1]), before.1 + counts[bin - 1]);
                // An empty group's is not a number.
                let cost = pricing.cost(before) + behind[bin];
                if cost < least {
                    (least, best) = (cost, Some((axis, bin)));
                }
            }
        }
        best.map(|(axis, bin)| {
            let (before, behind) = self.bounds[axis].split_at(bin);
            Plane { axis, bin, bounds: [around(before), around(behind)] }
        })
    }
}

impl Pricing {
    /// For a tree over so many boxes.
    ///
    /// Small ones are in the caches anyway, and rays are up to 5 % faster where groups are chosen for them alone. In
    /// large ones they are as fast with an empty place at half a block, which saves 2 to 4 % of the memory.
    pub fn of(boxes: usize) -> Self {
        Self { empty: if boxes > SMALL { 0.5 } else { 0.0 } }
    }

    fn cost(self, (bounds, count): (Aabb, u32)) -> f32 {
        let blocks = count.div_ceil(u32::from(LEAF));
        let empty = blocks * u32::from(LEAF) - count;
        bounds.half_area() * (blocks as f32 + self.empty * empty as f32)
    }
}
