//! Cubes: four at a time against a ray, or one at a time against four rays.

use super::packet::Packet;
use super::shaft::Plane;
use super::{Rays, Search};
use crate::math::simd::{F64x4, Mask, dot};
use crate::math::{Bounds, DVec3};
use crate::shape::Cube;
use crate::shape::cube::{ACROSS, dual_basis};

/// Four cubes; missing ones have a centre that nothing compares with.
#[derive(Clone, Debug)]
pub struct Cubes {
    centre: [F64x4; 3],
    /// Products with p − centre are the coordinates, from −1 to 1 within the cube.
    dual: [[F64x4; 3]; 3],
    /// The [`lane`](Packet::lane) of each one's first face.
    first: F64x4,
}

/// Where lines meet cubes.
struct Crossing {
    t: F64x4,
    /// The [`lane`](Packet::lane) of the face.
    face: F64x4,
    met: Mask,
}

/// A line and a cube in each lane: the first crossing beyond `start`.
///
/// Within the cube lies what all three pairs of planes have between them (Kay and Kajiya 1986), so a line that
/// misses no pair comes in by the last plane that lets it in, and leaves by the first that lets it out: there
/// is no crack at an edge. A ray that starts on a face has its distance 0 from that plane, whatever rounding
/// says, and can only leave.
#[inline(always)]
fn cross(
    (centre, dual, first): (&[F64x4; 3], &[[F64x4; 3]; 3], F64x4),
    origin: &[F64x4; 3],
    direction: &[F64x4; 3],
    (start, from): (F64x4, F64x4),
) -> Crossing {
    let [zero, one, minus_one] = [0.0, 1.0, -1.0].map(F64x4::splat);
    let o = [0, 1, 2].map(|axis| origin[axis] - centre[axis]);
    let from_cube = first.at_most(from) & from.below(first + F64x4::splat(f64::from(Cube::FACES)));
    let starts_here = from_cube.bits() != 0;
    let (mut enter, mut leave) = (F64x4::splat(f64::NEG_INFINITY), F64x4::splat(f64::INFINITY));
    let (mut by, mut out_by) = (zero, zero);
    for (dual, across) in dual.iter().zip(ACROSS) {
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
    let crosses = enter.at_most(leave) | from_cube;
    Crossing { t, face: first + comes_in.select(by, out_by), met: crosses & start.below(t) }
}

impl Cubes {
    pub fn new(items: &[(&Cube, u32)]) -> Self {
        let lanes = |f: &dyn Fn(&Cube) -> DVec3, rest: f64| {
            [0, 1, 2].map(|axis| {
                F64x4::new(std::array::from_fn(|i| items.get(i).map_or(rest, |(c, _)| f(c)[axis])))
            })
        };
        Self {
            centre: lanes(&|c| c.centre, f64::NAN),
            dual: [0, 1, 2].map(|k| lanes(&|c| c.dual()[k], 0.0)),
            first: F64x4::new(std::array::from_fn(|i| {
                items.get(i).map_or(f64::NAN, |(_, first)| Packet::lane(*first))
            })),
        }
    }

    /// Each face's number, its plane, and the corners of a box around it.
    pub fn faces(&self) -> impl Iterator<Item = (u32, Plane, Bounds)> {
        let there = (0..4).filter(|&lane| !self.first.lane(lane).is_nan());
        there.flat_map(move |lane| {
            let vector = |lanes: &[F64x4; 3]| DVec3::from_array(lanes.each_ref().map(|axis| axis.lane(lane)));
            let (centre, dual) = (vector(&self.centre), self.dual.each_ref().map(vector));
            // The axes are to the dual vectors what these are to the axes.
            let axes = dual_basis(dual);
            let first = Packet::primitive(self.first.lane(lane));
            let face = move |axis: usize, side: usize| {
                let middle = centre + axes[axis] * [-1.0, 1.0][side];
                let reach = axes[(axis + 1) % 3].abs() + axes[(axis + 2) % 3].abs();
                let plane = Plane::new(middle, dual[axis]);
                (first + ACROSS[axis][side], plane, (middle - reach, middle + reach))
            };
            (0..6).map(move |i| face(i / 2, i % 2))
        })
    }

    #[inline(always)]
    pub fn intersect(&self, rays: &Rays, search: &mut Search) {
        let from = F64x4::splat(Packet::lane(search.ray.from));
        let cubes = (&self.centre, &self.dual, self.first);
        let Crossing { t, face, met } = cross(cubes, &rays.origin, &rays.direction, (rays.start, from));
        let mut hits = (met & t.at_most(F64x4::splat(search.best.t))).bits();
        while hits != 0 {
            let i = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            search.offer(t.lane(i), 0.0, 0.0, Packet::primitive(face.lane(i)));
        }
    }

    /// The same for four rays.
    #[inline(always)]
    pub fn intersect_packet(&self, packet: &mut Packet) {
        for lane in 0..4 {
            if self.first.lane(lane).is_nan() {
                break;
            }
            let spread = |vector: &[F64x4; 3]| [0, 1, 2].map(|axis| vector[axis].spread(lane));
            let (centre, dual) = (spread(&self.centre), self.dual.each_ref().map(spread));
            let cube = (&centre, &dual, self.first.spread(lane));
            let Crossing { t, face, met } =
                cross(cube, &packet.origin, &packet.direction, (packet.start, packet.from));
            if met.bits() != 0 {
                packet.offer(t, F64x4::splat(0.0), F64x4::splat(0.0), face, met);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Transform, length};

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
