//! Flat pieces of surfaces, which lamps may lie in, and by how much their corners are rounded.

use crate::math::bounds::{around, corners};
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

    /// The box (world) around points.
    pub fn placed(&self, points: &[DVec3]) -> Bounds {
        around(points.iter().map(|point| self.place.point(*point)))
    }

    /// A bound of the rounding error in `f64` of a point, and the sizes of numbers that were rounded to `f32`.
    fn of(&self, p: DVec3) -> (f64, DVec3) {
        let error = position_error(sizes(self.place, p) + self.place.point(DVec3::ZERO).abs());
        let rounded = self.file.map_or(DVec3::ZERO, |file| {
            sizes(self.place, p.abs() + sizes(file, file.inverse.transform_point3(p)))
        });
        (error, rounded)
    }

    /// What no lamp is farther from the plane of a piece in a box that it lies in, along any axis, if lamps have
    /// points of this error.
    pub fn slack(&self, bounds: Bounds, error: f64) -> f64 {
        let of_corners = corners(bounds).map(|corner| self.of(corner));
        let most = of_corners.into_iter().fold((0.0f64, 0.0f64), |most, (error, rounded)| {
            (most.0.max(error), most.1.max(rounded.element_sum()))
        });
        ERRORS * (most.0 + error) + SINGLE * most.1
    }
}

/// A flat piece of a surface (world).
pub struct Facet {
    corners: [DVec3; MOST],
    count: usize,
    pub bounds: Bounds,
    error: f64,
    rounded: DVec3,
}

impl Facet {
    /// By at most [`MOST`] corners in the surface's coordinates.
    pub fn new(corners: &[DVec3], numbers: &Numbers) -> Self {
        let mut facet = Self {
            corners: [DVec3::ZERO; MOST],
            count: corners.len(),
            bounds: crate::math::bounds::NOTHING,
            error: 0.0,
            rounded: DVec3::ZERO,
        };
        for (placed, corner) in facet.corners.iter_mut().zip(corners) {
            *placed = numbers.place.point(*corner);
            let (error, rounded) = numbers.of(*corner);
            facet.error = facet.error.max(error);
            facet.rounded = facet.rounded.max(rounded);
        }
        facet.bounds = around(facet.corners[..facet.count].iter().copied());
        facet
    }

    /// No lamp whose points have this error is raised by more.
    pub fn slack(&self, error: f64) -> f64 {
        ERRORS * (self.error + error) + SINGLE * self.rounded.element_sum()
    }

    /// How far a lamp must be raised to lie upon this, if it lies in it: if all corners are in its plane, by what
    /// both are rounded.
    pub fn height(&self, lamp: &Patch) -> Option<f64> {
        // Across a level ceiling it is how high it is that has been rounded, not how wide.
        let height = ERRORS * (self.error + lamp.point_error()) + SINGLE * self.rounded.dot(lamp.n.abs());
        let in_plane = |corner: &DVec3| lamp.n.dot(*corner - lamp.centre).abs() <= height;
        self.corners[..self.count].iter().all(in_plane).then_some(height)
    }
}
