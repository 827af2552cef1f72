//! Cubes: four at a time against a ray, or one at a time against four rays.

use super::packet::Packet;
use super::shaft::Plane;
use super::{Rays, Search};
use crate::math::simd::{F64x4, Mask, dot};
use crate::math::{Bounds, DVec3};
use crate::shape::Cube;
use crate::shape::cube::ACROSS;

/// Four cubes; missing ones have a centre that nothing compares with.
#[derive(Clone, Debug)]
pub struct Cubes {
    centre: [F64x4; 3],
    /// Products with p − centre are the coordinates, from −1 to 1 within the cube.
    dual: [[F64x4; 3]; 3],
    /// The [`lane`](Packet::lane) of each one's first face.
    first: F64x4,
    /// Planes and boxes of the faces, for shafts.
    faces: Vec<(u32, Plane, Bounds)>,
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
        let faces = |(cube, first): &(&Cube, u32)| {
            let first = *first;
            let faces = (*cube.faces()).into_iter().zip(first..);
            faces.map(|(face, primitive)| (primitive, Plane::new(face.centre, face.n), face.bounds()))
        };
        Self {
            centre: lanes(&|c| c.centre, f64::NAN),
            dual: [0, 1, 2].map(|k| lanes(&|c| c.dual()[k], 0.0)),
            first: F64x4::new(std::array::from_fn(|i| {
                items.get(i).map_or(f64::NAN, |(_, first)| Packet::lane(*first))
            })),
            faces: items.iter().flat_map(faces).collect(),
        }
    }

    /// Each face's number, its plane, and the corners of a box around it.
    pub fn faces(&self) -> impl Iterator<Item = (u32, Plane, Bounds)> {
        self.faces.iter().copied()
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
