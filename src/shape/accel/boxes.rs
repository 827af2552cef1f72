//! What a binary tree is grown from: a box around every item, or several around a thin triangle, and what each item
//! is in a leaf.

use super::Instance;
use super::collapse::{Content, LEAF, kind};
use super::items::Item;
use super::space::Space;
use super::splits::{Pieces, cut, is_thin};
use crate::math::bounds::around;
use crate::math::{Bounds, DVec3, length};
use crate::pages::Pages;
use crate::shape::Geometry;
use glam::Vec3A;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Boxes in unit coordinates, and what is in them.
pub struct Boxes {
    /// In large pages, for every level of the tree passes through them all.
    pub boxes: Pages<Aabb>,
    /// The item in each box.
    pub items: Vec<u32>,
    /// What each item is in a leaf.
    pub contents: Pages<Content>,
}

impl Boxes {
    pub fn new(shapes: &[&Geometry], instances: &[Instance], items: &[Item], space: &Space) -> Self {
        let thin = |(i, item): (usize, &Item)| match shapes.get(item.shape as usize) {
            Some(Geometry::Mesh(mesh)) => {
                let corners = mesh.corners(item.local);
                is_thin(corners).then_some((i as u32, corners))
            }
            _ => None,
        };
        let thin: Vec<(u32, [DVec3; 3])> = items.par_iter().enumerate().filter_map(thin).collect();
        let Pieces { first, others } = cut(thin, items.len());
        let mut boxes = Pages::zeroed(items.len() + others.len());
        let (of_items, of_others) = boxes.split_at_mut(items.len());
        let mut contents = Pages::zeroed(items.len());
        let measured = of_items.par_iter_mut().zip(&mut *contents).zip(items);
        measured
            .for_each(|((aabb, content), item)| (*aabb, *content) = measure(shapes, instances, item, space));
        for piece in &first {
            of_items[piece.of as usize] = boxed(space, piece.bounds());
        }
        for (aabb, piece) in of_others.iter_mut().zip(&others) {
            *aabb = boxed(space, piece.bounds());
        }
        let mut of_boxes: Vec<u32> = (0..items.len() as u32).into_par_iter().collect();
        of_boxes.extend(others.iter().map(|piece| piece.of));
        Self { boxes, items: of_boxes, contents }
    }
}

/// The box around an item, and what it is in a leaf.
fn measure(shapes: &[&Geometry], instances: &[Instance], item: &Item, space: &Space) -> (Aabb, Content) {
    let Some(shape) = shapes.get(item.shape as usize) else {
        let aabb = boxed(space, instances[item.shape as usize - shapes.len()].bounds());
        // A leaf of its own.
        return (aabb, Content { surface: aabb.half_area(), size: LEAF, kind: kind::INSTANCE });
    };
    let kind = match shape {
        Geometry::Mesh(mesh) => {
            let [a, b, c] = mesh.corners(item.local);
            let unit = space.scale() * space.scale();
            let surface = (length((b - a).cross(c - a)) * unit) as f32;
            return (boxed(space, around([a, b, c])), Content { surface, size: 1, kind: kind::TRIANGLE });
        }
        Geometry::Patch(_) => kind::PATCH,
        Geometry::Cube(_) => kind::CUBE,
        Geometry::Sphere(_) => kind::SPHERE,
        Geometry::Cylinder(_) => kind::CYLINDER,
    };
    let aabb = boxed(space, shape.bounds());
    (aabb, Content { surface: aabb.half_area(), size: 1, kind })
}

fn boxed(space: &Space, (lo, hi): Bounds) -> Aabb {
    let (lo, hi) = space.enclose(lo, hi);
    Aabb::new(Vec3A::from_array(lo), Vec3A::from_array(hi))
}
