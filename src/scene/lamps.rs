//! Lamps that lie in the plane of another surface, such as a panel in a ceiling.
//!
//! Rounding would decide which of the two a ray meets, while an emitter sample ends just before its lamp and
//! arrives: MIS of the two techniques would lose what the surface hides from one of them. So flat lamps are
//! raised a little above whatever they lie in, and the faces of cubes that shine as well. How little depends on what
//! they lie in: the corners of meshes are rounded to `f32`, which may have put a ceiling before its lamp. Of several
//! lamps in one plane that face the same way, each lies upon those that the file has before it.

mod faces;
mod facet;
mod surfaces;

use super::Shape;
use super::instances::Instances;
use crate::math::Transform;
use crate::shape::{Geometry, Patch};
use faces::{Face, Faces};
use facet::{Facet, Numbers};
use surfaces::Surfaces;

/// The flat sides of a lamp that can be moved: vertices of meshes have fewer digits, and triangles share edges with
/// others.
fn patches(geometry: &Geometry) -> &[Patch] {
    match geometry {
        Geometry::Patch(patch) => std::slice::from_ref(patch),
        Geometry::Cube(cube) => cube.faces(),
        Geometry::Mesh(_) | Geometry::Sphere(_) | Geometry::Cylinder(_) => &[],
    }
}

/// Raises flat lamps, by less than can be seen and more than rounding.
pub fn raise(shapes: &mut [Shape], instances: &Instances) {
    let faces = Faces::of(shapes);
    if faces.is_empty() {
        return;
    }
    let mut heights = vec![0.0f64; shapes.len()];
    let mut raised = |face: &Face, height: f64| heights[face.shape] = heights[face.shape].max(height);
    let is_flat_lamp = |shape: &&Shape| shape.emitter.is_some() && !patches(&shape.geometry).is_empty();
    let others = shapes.iter().filter(|shape| !is_flat_lamp(shape));
    Surfaces::of(others).each_face_in(&Transform::IDENTITY, &faces, &mut raised);
    let groups: Vec<Surfaces> = instances.groups().map(Surfaces::of).collect();
    for (group, to_world) in instances.placements() {
        groups[group].each_face_in(to_world, &faces, &mut raised);
    }
    let here = Numbers::of_patches(&Transform::IDENTITY);
    for number in 0..shapes.len() {
        for patch in patches(&shapes[number].geometry).iter().filter(|_| shapes[number].emitter.is_some()) {
            let mut most = heights[number];
            faces.each_in(&Facet::new(&patch.corners(), &here), &mut |face: &Face, height: f64| {
                if face.patch.n.dot(patch.n) < 0.0 {
                    // Back to back: each of the two leaves the plane by its own front.
                    most = most.max(height);
                } else if face.shape < number {
                    most = most.max(heights[face.shape] + height);
                }
            });
            heights[number] = most;
        }
    }
    for (shape, height) in shapes.iter_mut().zip(heights).filter(|(_, height)| *height > 0.0) {
        match &mut shape.geometry {
            Geometry::Patch(patch) => patch.centre += patch.n * height,
            Geometry::Cube(cube) => cube.raise(height),
            Geometry::Mesh(_) | Geometry::Sphere(_) | Geometry::Cylinder(_) => {}
        }
    }
}

#[cfg(test)]
mod tests;
