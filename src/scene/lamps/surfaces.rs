//! What lamps may lie in, in coordinates of its own: most of it is far from all lamps, and is passed over as a whole.

use super::faces::{Face, Faces};
use super::facet::{Facet, Numbers, Rounding};
use super::patches;
use crate::math::bounds::{NOTHING, around, corners, union};
use crate::math::{Bounds, DVec3, Transform};
use crate::scene::Shape;
use crate::shape::{Geometry, Mesh};
use std::ops::Range;

/// Triangles that are passed over together, if they can be: those that follow each other in a file are often
/// neighbours.
const RUN: u32 = 64;

/// Shapes that are placed together.
pub struct Surfaces<'a> {
    surfaces: Vec<Surface<'a>>,
    /// Of all together.
    extent: Extent,
}

/// A shape with flat pieces.
struct Surface<'a> {
    geometry: &'a Geometry,
    extent: Extent,
    /// Boxes around [`RUN`] triangles each.
    runs: Vec<Bounds>,
}

/// Where something is, and the sizes of the numbers along each axis that were rounded to `f32` there.
struct Extent {
    bounds: Bounds,
    single: DVec3,
}

impl<'a> Surfaces<'a> {
    pub fn of(shapes: impl IntoIterator<Item = &'a Shape>) -> Self {
        let surfaces: Vec<Surface> =
            shapes.into_iter().filter_map(|shape| Surface::of(&shape.geometry)).collect();
        let extent = surfaces.iter().fold(Extent { bounds: NOTHING, single: DVec3::ZERO }, |all, surface| {
            let Extent { bounds, single } = surface.extent;
            Extent { bounds: union(all.bounds, bounds), single: all.single.max(single) }
        });
        Self { surfaces, extent }
    }

    /// Calls `f` with every lamp's face that lies in one of the flat pieces, and how far it must be raised to lie upon
    /// that. `place` leads from the coordinates of the shapes to the world's.
    pub fn each_face_in(&self, place: &Transform, faces: &Faces, f: &mut impl FnMut(&Face, f64)) {
        if self.surfaces.is_empty() || !self.extent.is_near(place, faces) {
            return;
        }
        for surface in self.surfaces.iter().filter(|surface| surface.extent.is_near(place, faces)) {
            surface.each_face_in(place, faces, f);
        }
    }
}

impl<'a> Surface<'a> {
    fn of(geometry: &'a Geometry) -> Option<Self> {
        let bounds = geometry.bounds();
        let (runs, single) = match geometry {
            Geometry::Mesh(mesh) => {
                let numbers = Numbers::of_mesh(&Transform::IDENTITY, mesh.placement());
                let single =
                    corners(bounds).map(|p| numbers.single(p)).into_iter().fold(DVec3::ZERO, DVec3::max);
                let around = |run: Range<u32>| around(run.flat_map(|triangle| mesh.corners(triangle)));
                (runs(mesh).map(around).collect(), single)
            }
            Geometry::Patch(_) | Geometry::Cube(_) => (vec![], DVec3::ZERO),
            Geometry::Sphere(_) | Geometry::Cylinder(_) => return None,
        };
        Some(Self { geometry, extent: Extent { bounds, single }, runs })
    }

    fn each_face_in(&self, place: &Transform, faces: &Faces, f: &mut impl FnMut(&Face, f64)) {
        if let Geometry::Mesh(mesh) = self.geometry {
            let numbers = Numbers::of_mesh(place, mesh.placement());
            let slack = self.extent.rounding(place).slack(faces.error);
            for (bounds, run) in self.runs.iter().zip(runs(mesh)) {
                if !faces.are_near(placed(&corners(*bounds), place), slack) {
                    continue;
                }
                for triangle in run {
                    let corners = mesh.corners(triangle);
                    if faces.are_near(placed(&corners, place), slack) {
                        faces.each_in(&Facet::new(&corners, &numbers), f);
                    }
                }
            }
        }
        let numbers = Numbers::of_patches(place);
        for patch in patches(self.geometry) {
            faces.each_in(&Facet::new(&patch.corners(), &numbers), f);
        }
    }
}

impl Extent {
    /// A bound of the rounding of all points, placed.
    fn rounding(&self, place: &Transform) -> Rounding {
        let (lo, hi) = self.bounds;
        Rounding::of(place, lo.abs().max(hi.abs()), self.single)
    }

    fn is_near(&self, place: &Transform, faces: &Faces) -> bool {
        let slack = self.rounding(place).slack(faces.error);
        faces.are_near(placed(&corners(self.bounds), place), slack)
    }
}

/// The numbers of a mesh's triangles, [`RUN`] at a time.
fn runs(mesh: &Mesh) -> impl Iterator<Item = Range<u32>> {
    let count = mesh.triangles.len() as u32;
    (0..count).step_by(RUN as usize).map(move |first| first..count.min(first.saturating_add(RUN)))
}

/// The box (world) around points.
fn placed(points: &[DVec3], place: &Transform) -> Bounds {
    around(points.iter().map(|point| place.point(*point)))
}
