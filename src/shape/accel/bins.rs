//! Division of boxes into two groups.
//!
//! Their centres go into bins along each axis, and the plane between two bins is taken that costs rays least
//! by the surface area heuristic (Wald 2007, "On Fast Construction of SAH-Based Bounding Volume Hierarchies",
//! section 3). Size is an axis too: so the walls of a room are separated from what stands in it, whose boxes
//! they would enlarge.

use super::fold::LEAF;
use glam::Vec4;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Minimum and maximum of no coordinates.
const NOTHING: (Vec4, Vec4) = (Vec4::INFINITY, Vec4::NEG_INFINITY);

/// Fewest boxes that are processed by several threads.
const MANY: usize = 1 << 16;

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
    cost: f32,
    bounds: [Aabb; 2],
}

/// Sorts at least two boxes into two groups, and their items likewise. Returns the size of the first and the
/// boxes around both. Neither group is empty.
pub fn divide(boxes: &mut [Aabb], items: &mut [u32]) -> (usize, [Aabb; 2]) {
    match boxes.len() {
        0..=16 => divide_by::<8, 3>(boxes, items),
        17..=512 => divide_by::<16, 3>(boxes, items),
        _ => divide_by::<32, 4>(boxes, items),
    }
}

fn divide_by<const BINS: usize, const AXES: usize>(
    boxes: &mut [Aabb],
    items: &mut [u32],
) -> (usize, [Aabb; 2]) {
    let scale = Scale::<BINS>::new(boxes);
    let best = Bins::<BINS, AXES>::new(boxes, scale).best();
    let Some(plane) = best else {
        // All centres are in one place.
        let (one, other) = boxes.split_at(boxes.len() / 2);
        return (one.len(), [around(one), around(other)]);
    };
    // Without a branch that could be mispredicted: each box in turn is swapped with the first that is behind
    // the plane.
    let mut at = 0;
    for i in 0..boxes.len() {
        let before = scale.bins(&boxes[i])[plane.axis] < plane.bin;
        boxes.swap(i, at);
        items.swap(i, at);
        at += usize::from(before);
    }
    (at, plane.bounds)
}

/// The box around all.
pub fn around(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::empty(), |all, next| all.union(next))
}

/// Twice the centre, and the longest edge.
#[inline(always)]
fn coordinates(aabb: &Aabb) -> Vec4 {
    (aabb.min + aabb.max).extend((aabb.max - aabb.min).max_element())
}

impl<const BINS: usize> Scale<BINS> {
    fn new(boxes: &[Aabb]) -> Self {
        let extent = |boxes: &[Aabb]| {
            boxes.iter().map(coordinates).fold(NOTHING, |(lo, hi), at| (lo.min(at), hi.max(at)))
        };
        let (lo, hi) = if boxes.len() < MANY {
            extent(boxes)
        } else {
            boxes.par_chunks(MANY / 4).map(extent).reduce(|| NOTHING, |a, b| (a.0.min(b.0), a.1.max(b.1)))
        };
        // An axis without extent gets infinity or NaN.
        Self { origin: lo, factor: Vec4::splat((BINS - 1) as f32) / (hi - lo) }
    }

    #[inline(always)]
    fn bins(&self, aabb: &Aabb) -> [usize; 4] {
        // Next to 2²³ there are only whole numbers, whose bits end with what was added. Infinity and NaN end
        // with zeros.
        let whole = (coordinates(aabb) - self.origin) * self.factor + Vec4::splat(8388608.0);
        whole.to_array().map(|x| x.to_bits() as usize % BINS)
    }
}

impl<const BINS: usize, const AXES: usize> Bins<BINS, AXES> {
    const EMPTY: Self = Self { bounds: [[Aabb::INVALID; BINS]; AXES], counts: [[0; BINS]; AXES] };

    fn new(boxes: &[Aabb], scale: Scale<BINS>) -> Self {
        let sort = |boxes: &[Aabb]| {
            let mut bins = Self::EMPTY;
            for aabb in boxes {
                for (axis, bin) in scale.bins(aabb).into_iter().enumerate().take(AXES) {
                    bins.bounds[axis][bin] = bins.bounds[axis][bin].union(aabb);
                    bins.counts[axis][bin] += 1;
                }
            }
            bins
        };
        if boxes.len() < MANY {
            sort(boxes)
        } else {
            boxes.par_chunks(MANY / 4).map(sort).reduce(|| Self::EMPTY, Self::and)
        }
    }

    fn and(mut self, other: Self) -> Self {
        for axis in 0..AXES {
            for bin in 0..BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(&other.bounds[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The plane of least cost, the first one of several; none if one bin has all.
    fn best(&self) -> Option<Plane> {
        let mut best: Option<Plane> = None;
        for axis in 0..AXES {
            let (bounds, counts) = (&self.bounds[axis], &self.counts[axis]);
            // Of all bins from one on.
            let mut behind = [(Aabb::INVALID, 0); BINS];
            let mut all = (Aabb::INVALID, 0);
            for bin in (1..BINS).rev() {
                all = (all.0.union(&bounds[bin]), all.1 + counts[bin]);
                behind[bin] = all;
            }
            let mut before = (Aabb::INVALID, 0);
            for bin in 1..BINS {
                before = (before.0.union(&bounds[bin - 1]), before.1 + counts[bin - 1]);
                if before.1 == 0 || behind[bin].1 == 0 {
                    continue;
                }
                let cost = price(before) + price(behind[bin]);
                if best.is_none_or(|best| cost < best.cost) {
                    best = Some(Plane { axis, bin, cost, bounds: [before.0, behind[bin].0] });
                }
            }
        }
        best
    }
}

/// Cost of a group for rays: its area, for each block that it fills.
fn price((bounds, count): (Aabb, u32)) -> f32 {
    bounds.half_area() * count.div_ceil(u32::from(LEAF)) as f32
}
