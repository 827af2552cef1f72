//! Bounds of a density, block by block, and the walk of a ray through them.

use crate::math::DVec3;

/// Most blocks along an axis.
const MOST: usize = 32;

/// Cells of the density to a block, along each axis: few enough that bounds are tight, enough that the walk
/// is not most of the work.
const CELLS: usize = 4;

/// Bounds of a density over blocks of the unit cube.
#[derive(Debug)]
pub struct Majorants {
    size: [usize; 3],
    /// x fastest.
    bounds: Vec<f32>,
}

/// A part of a ray within one block.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Distances along the ray.
    pub begin: f64,
    pub end: f64,
    /// No density there is above this.
    pub majorant: f32,
}

impl Majorants {
    /// For a density of this many cells, bounded over any box within the unit cube by `bound`.
    pub fn new(cells: [usize; 3], bound: impl Fn(DVec3, DVec3) -> f32) -> Self {
        let size = cells.map(|n| n.div_ceil(CELLS).min(MOST));
        let steps = DVec3::from(size.map(|n| n as f64));
        let mut bounds = Vec::with_capacity(size.iter().product());
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    let corner = DVec3::from([i, j, k].map(|i| i as f64));
                    bounds.push(bound(corner / steps, (corner + DVec3::ONE) / steps));
                }
            }
        }
        Self { size, bounds }
    }

    /// The largest bound.
    pub fn most(&self) -> f32 {
        self.bounds.iter().copied().fold(0.0, f32::max)
    }

    /// The parts of a ray in the unit cube's coordinates, up to `length` of its direction, from the first to
    /// the last, and without those outside of the cube.
    pub fn walk(&self, origin: DVec3, direction: DVec3, length: f64) -> impl Iterator<Item = Part> {
        let (mut t, end) = inside(origin, direction, length);
        let steps = DVec3::from(self.size.map(|n| n as f64));
        let (from, along) = (origin * steps, direction * steps);
        // Blocks are stepped along by number, so that no rounding can lead back.
        let first = from + along * t;
        let mut block = [0, 1, 2].map(|axis| (first[axis] as usize).min(self.size[axis] - 1));
        std::iter::from_fn(move || {
            if t >= end {
                return None;
            }
            // Where the ray leaves the block along each axis; never, if it runs across it.
            let leaves = |axis: usize| {
                let wall = block[axis] as f64 + if along[axis] > 0.0 { 1.0 } else { 0.0 };
                if along[axis] == 0.0 { f64::INFINITY } else { (wall - from[axis]) / along[axis] }
            };
            let axis = (1..3).fold(0, |best, axis| if leaves(axis) < leaves(best) { axis } else { best });
            let [i, j, k] = block;
            let majorant = self.bounds[(k * self.size[1] + j) * self.size[0] + i];
            let part = Part { begin: t, end: leaves(axis).clamp(t, end), majorant };
            t = part.end;
            block[axis] = if along[axis] > 0.0 { block[axis] + 1 } else { block[axis].wrapping_sub(1) };
            if block[axis] >= self.size[axis] {
                t = end;
            }
            Some(part)
        })
    }
}

/// The distances between which a ray is in the unit cube; empty if it misses.
fn inside(origin: DVec3, direction: DVec3, length: f64) -> (f64, f64) {
    let (mut begin, mut end) = (0.0f64, length);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            if !(0.0..=1.0).contains(&origin[axis]) {
                return (0.0, 0.0);
            }
            continue;
        }
        let (a, b) = (-origin[axis] / direction[axis], (1.0 - origin[axis]) / direction[axis]);
        (begin, end) = (begin.max(a.min(b)), end.min(a.max(b)));
    }
    (begin, end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::unit;

    /// A bound that names its block.
    fn majorants(cells: [usize; 3]) -> Majorants {
        let mut majorants = Majorants::new(cells, |_, _| 0.0);
        majorants.bounds.iter_mut().zip(0..).for_each(|(bound, i)| *bound = i as f32);
        majorants
    }

    #[test]
    fn parts_follow_one_another_and_lie_in_their_blocks() {
        let majorants = majorants([17, 8, 40]);
        assert_eq!(majorants.size, [5, 2, 10]);
        for i in 0..400 {
            let part = |step: f64| (0.5 + f64::from(i) * step).fract() * 3.0 - 1.0;
            let origin = DVec3::new(part(0.618_034), part(0.754_878), part(0.569_84));
            let towards = DVec3::new(part(0.819_173), part(0.671_044), part(0.549_7)) * 0.3 + 0.2;
            let direction = unit(towards - origin);
            let mut last: Option<Part> = None;
            for part in majorants.walk(origin, direction, 10.0) {
                assert!(part.begin <= part.end && last.is_none_or(|last| last.end == part.begin));
                let middle = origin + direction * (0.5 * (part.begin + part.end));
                let block = [0, 1, 2].map(|axis| (middle[axis] * majorants.size[axis] as f64) as usize);
                let number = (block[2] * 2 + block[1]) * 5 + block[0];
                let thin = part.end - part.begin < 1e-12;
                assert!(thin || part.majorant == number as f32, "{origin} {direction} {part:?} {number}");
                last = Some(part);
            }
            // The whole of what is inside.
            let (begin, end) = inside(origin, direction, 10.0);
            let whole = last.map_or(begin >= end, |last| (last.end - end).abs() < 1e-12);
            assert!(whole, "{origin} {direction} {last:?} {begin} {end}");
        }
    }

    #[test]
    fn rays_along_walls_and_short_rays_are_walked() {
        let majorants = majorants([8, 8, 8]);
        let parts = |origin: DVec3, direction: DVec3, length: f64| {
            let parts: Vec<_> = majorants.walk(origin, direction, length).collect();
            parts.iter().map(|part| part.end - part.begin).sum::<f64>()
        };
        assert_eq!(parts(DVec3::new(0.5, 0.5, -1.0), DVec3::Z, 10.0), 1.0);
        assert_eq!(parts(DVec3::new(0.0, 1.0, -1.0), DVec3::Z, f64::INFINITY), 1.0);
        assert_eq!(parts(DVec3::new(1.5, 0.5, -1.0), DVec3::Z, 10.0), 0.0);
        assert_eq!(parts(DVec3::splat(0.5), -DVec3::Y, 0.25), 0.25);
        assert_eq!(parts(DVec3::splat(0.5), -DVec3::Y, 0.0), 0.0);
        assert_eq!(parts(DVec3::new(0.5, 0.5, 2.0), DVec3::Z, 10.0), 0.0);
    }
}
