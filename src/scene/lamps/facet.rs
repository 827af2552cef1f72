//! Flat pieces of surfaces, which lamps may lie in, and by how much their corners are rounded.

use crate::math::bounds::{NOTHING, around};
use crate::math::ray::position_error;
use crate::math::{Bounds, DVec3, Transform};
use crate::shape::Patch;

/// By how many times the errors of computed points a lamp is raised: beyond the errors of both surfaces along a
/// ray, and beyond where emitter samples end ([`free_way`](crate::math::ray::free_way)).
const ERRORS: f64 = 16.0;

/// What a number loses when it is rounded to `f32`, relative to it.
const SINGLE: f64 = 1.0 / (1u64 << 24) as f64;

/// Most corners of a flat piece.
const MOST: usize = 4;

/// Where the coordinates of a surface's corners come from: what they are sums of loses digits, also where the sums are
/// small.
pub struct Numbers<'a> {
    /// To the world.
    place: &'a Transform,
    /// From the file's coordinates, of which those of meshes were rounded to `f32`, as their products were.
    file: Option<&'a Transform>,
}

/// The sizes of the numbers that the coordinates along each axis are sums of.
fn sizes(transform: &Transform, p: DVec3) -> DVec3 {
    let axes = DVec3::AXES.map(|axis| transform.vector(axis).abs());
    axes[0] * p.x.abs() + axes[1] * p.y.abs() + axes[2] * p.z.abs()
}

impl<'a> Numbers<'a> {
    pub fn of_patches(place: &'a Transform) -> Self {
        Self { place, file: None }
    }

    pub fn of_mesh(place: &'a Transform, file: &'a Transform) -> Self {
        Self { place, file: Some(file) }
    }

    /// By how much a point is rounded.
    fn rounding(&self, p: DVec3) -> Rounding {
        Rounding::of(self.place, p, self.single(p))
    }

    /// The sizes of the numbers that were rounded to `f32`, in the surface's coordinates.
    pub fn single(&self, p: DVec3) -> DVec3 {
        self.file.map_or(DVec3::ZERO, |file| p.abs() + sizes(file, file.inverse.transform_point3(p)))
    }
}

/// By how much points are rounded.
#[derive(Clone, Copy, Default)]
pub struct Rounding {
    /// A bound of the error in `f64`.
    error: f64,
    /// The sizes of the numbers along each axis that were rounded to `f32`.
    single: DVec3,
}

impl Rounding {
    /// Of a point in a surface's coordinates, where numbers of these sizes were rounded to `f32`. It grows with the
    /// coordinates.
    pub fn of(place: &Transform, p: DVec3, single: DVec3) -> Self {
        Self {
            error: position_error(sizes(place, p) + place.point(DVec3::ZERO).abs()),
            single: sizes(place, single),
        }
    }

    fn max(self, other: Self) -> Self {
        Self { error: self.error.max(other.error), single: self.single.max(other.single) }
    }

    /// How far a lamp that faces along `n`, whose points have such an error, must be raised above such points.
    fn height(&self, error: f64, n: DVec3) -> f64 {
        // Across a level ceiling it is how high it is that has been rounded, not how wide.
        ERRORS * (self.error + error) + SINGLE * self.single.dot(n.abs())
    }

    /// No lamp must be raised by more, wherever it faces.
    pub fn slack(&self, error: f64) -> f64 {
        self.height(error, DVec3::ONE)
    }
}

/// A flat piece of a surface (world).
pub struct Facet {
    corners: [DVec3; MOST],
    count: usize,
    pub bounds: Bounds,
    pub rounding: Rounding,
}

impl Facet {
    /// By at most [`MOST`] corners in the surface's coordinates.
    pub fn new(corners: &[DVec3], numbers: &Numbers) -> Self {
        let mut facet = Self {
            corners: [DVec3::ZERO; MOST],
            count: corners.len(),
            bounds: NOTHING,
            rounding: Rounding::default(),
        };
        for (placed, corner) in facet.corners.iter_mut().zip(corners) {
            *placed = numbers.place.point(*corner);
            facet.rounding = facet.rounding.max(numbers.rounding(*corner));
        }
        facet.bounds = around(facet.corners[..facet.count].iter().copied());
        facet
    }

    /// How far a lamp must be raised to lie upon this, if it lies in it: if all corners are in its plane, by what
    /// both are rounded.
    pub fn height(&self, lamp: &Patch) -> Option<f64> {
        let height = self.rounding.height(lamp.point_error(), lamp.n);
        let in_plane = |corner: &DVec3| lamp.n.dot(*corner - lamp.centre).abs() <= height;
        self.corners[..self.count].iter().all(in_plane).then_some(height)
    }
}
