//! Cubes.

use super::block::{Block, Crossing, Rays, numbers, spread, vector, vectors};
use super::shaft::Plane;
use crate::math::Bounds;
use crate::math::simd::{F64x4, dot};
use crate::shape::Cube;
use crate::shape::cube::{ACROSS, dual_basis};

/// Four cubes; missing ones have a centre that nothing compares with.
#[derive(Clone, Debug)]
pub struct Cubes {
    centre: [F64x4; 3],
    /// Dual vectors, whose products with p − centre are the coordinates, from −1 to 1 within the cube.
    dual: [[F64x4; 3]; 3],
    /// The number of each one's first face.
    first: F64x4,
}

impl Cubes {
    /// Each face's number, its plane, and the corners of a box around it.
    pub fn faces(&self) -> impl Iterator<Item = (u32, Plane, Bounds)> {
        self.there().flat_map(|(lane, first)| {
            let (centre, dual) = (vector(&self.centre, lane), self.dual.each_ref().map(|d| vector(d, lane)));
            // The axes are to the dual vectors what these are to the axes.
            let axes = dual_basis(dual);
            let face = move |axis: usize, side: usize| {
                let middle = centre + axes[axis] * [-1.0, 1.0][side];
                let reach = axes[(axis + 1) % 3].abs() + axes[(axis + 2) % 3].abs();
                let plane = Plane::new(middle, dual[axis]);
                (first + ACROSS[axis][side], plane, (middle - reach, middle + reach))
            };
            (0..6).map(move |i| face(i / 2, i % 2))
        })
    }
}

impl Block for Cubes {
    type Shape = Cube;

    fn new(items: &[(&Cube, u32)]) -> Self {
        Self {
            centre: vectors(items, f64::NAN, |c| c.centre),
            dual: [0, 1, 2].map(|k| vectors(items, 0.0, |c| c.dual[k])),
            first: numbers(items),
        }
    }

    #[inline(always)]
    fn primitives(&self) -> &F64x4 {
        &self.first
    }

    #[inline(always)]
    fn spread(&self, lane: usize) -> Self {
        Self {
            centre: spread(&self.centre, lane),
            dual: self.dual.each_ref().map(|dual| spread(dual, lane)),
            first: self.first.spread(lane),
        }
    }

    /// The first crossing of a line and a cube beyond `start`.
    ///
    /// Within the cube lies what all three pairs of planes have between them (Kay and Kajiya 1986), so a line
    /// that misses no pair comes in by the last plane that lets it in, and leaves by the first that lets it
    /// out: there is no crack at an edge. A ray that starts on a face has its distance 0 from that plane,
    /// whatever rounding says, and can only leave.
    #[inline(always)]
    fn cross(&self, Rays { origin, direction, start, from, .. }: &Rays) -> Option<Crossing> {
        let [zero, one, minus_one] = [0.0, 1.0, -1.0].map(F64x4::splat);
        let first = self.first;
        let o = [0, 1, 2].map(|axis| origin[axis] - self.centre[axis]);
        let from_cube = first.at_most(*from) & from.below(first + F64x4::splat(f64::from(Cube::FACES)));
        let starts_here = from_cube.bits() != 0;
        let (mut enter, mut leave) = (F64x4::splat(f64::NEG_INFINITY), F64x4::splat(f64::INFINITY));
        let (mut by, mut out_by) = (zero, zero);
        for (dual, across) in self.dual.iter().zip(ACROSS) {
            let x = dot(*dual, o);
            let slope = dot(*dual, *direction);
            let inverse = one / slope;
            let [low, high] = across.map(|face| F64x4::splat(f64::from(face)));
            // Along the planes ±∞, and NaN in one of them, which is no crossing.
            let mut at_low = (minus_one - x) * inverse;
            let mut at_high = (one - x) * inverse;
            if starts_here {
                at_low = from.equals(first + low).select(zero, at_low);
                at_high = from.equals(first + high).select(zero, at_high);
            }
            let falling = slope.negative();
            let (near, far) = (falling.select(at_high, at_low), falling.select(at_low, at_high));
            let later = enter.below(near);
            enter = later.select(near, enter);
            by = later.select(falling.select(high, low), by);
            let sooner = far.below(leave);
            leave = sooner.select(far, leave);
            out_by = sooner.select(falling.select(low, high), out_by);
        }
        let comes_in = start.below(enter).without(from_cube);
        let t = comes_in.select(enter, leave);
        // What starts on a face is within the cube, or leaves at once.
        let met = (enter.at_most(leave) | from_cube) & start.below(t);
        if met.bits() == 0 {
            return None;
        }
        Some(Crossing::plain(t, first + comes_in.select(by, out_by), met))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Transform, length};

    #[test]
    fn faces_are_those_of_the_cubes() {
        let place = |x: f64| {
            let turn = Transform::rotate(DVec3::new(1.0, x, 0.3), 50.0).unwrap();
            let scale = Transform::scale(DVec3::new(0.5, -2.0, 1.0 + x)).unwrap();
            Transform::translate(DVec3::X * x).after(&turn).after(&scale).after(&turn)
        };
        let cubes = [0.2, 3.0].map(|x| Cube::new(&place(x), false));
        let block = Cubes::new(&[(&cubes[0], 7), (&cubes[1], 20)]);
        let mut faces: Vec<(u32, Plane, Bounds)> = block.faces().collect();
        faces.sort_by_key(|face| face.0);
        let expected = (7..).zip(cubes[0].faces()).chain((20..).zip(cubes[1].faces()));
        assert_eq!(faces.len(), 12);
        for ((primitive, plane, bounds), (number, patch)) in faces.into_iter().zip(expected) {
            assert_eq!(primitive, number);
            let [lo, hi] = [bounds.0 - patch.bounds().0, bounds.1 - patch.bounds().1].map(length);
            assert!(lo < 1e-13 && hi < 1e-13, "{bounds:?} {patch:?}");
            for corner in patch.corners() {
                assert!(plane.height(corner).abs() < 1e-13, "{plane:?} {corner}");
            }
        }
    }
}
