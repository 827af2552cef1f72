//! A uniform caustic that practically only light paths find, so that an error of theirs shows fully.
//!
//! A flat mirror, upright beside the floor, reflects the light of a small and distant lamp onto it, and a
//! screen blocks the direct light. One of a million camera paths hits the lamp by way of the mirror.

use super::caustics::with_light_paths;
use super::still_life::INDEPENDENT;
use super::{Relation, Term, chosen};
use crate::stage::*;
use validation::image::Image;

/// Pixels along each side of the film.
const SIZE: u32 = 6;

/// The lit floor from above, through a reconstruction filter.
fn floor(filter: &str) -> String {
    let place = to_world(&[look_at([0.0, 0.0, 6.0], [0.0; 3], [0.0, 1.0, 0.0])]);
    let film = film(SIZE, SIZE).replace("<rfilter type=\"box\"/>", &format!("<rfilter type=\"{filter}\"/>"));
    let camera = format!("<sensor type=\"orthographic\">{place}{film}{INDEPENDENT}</sensor>");
    let upright = |x: f64, z: f64, half: f64, towards: f64, wears: &str| {
        let steps = [scale([half, half, 1.0]), rotate('y', towards), translate([x, 0.0, z])];
        shape("rectangle", &steps, wears)
    };
    // The lamp's mirror image is at (90, 0, 90), so light on its way to a point of the floor crosses the
    // mirror at a third of the distance. The whole lamp must be visible in the mirror from every point in
    // view, which extends 1 to each side.
    const LAMP: f64 = 0.1;
    let mirror = 2.0 / 3.0 + LAMP / 3.0 + 0.01;
    scene(&[
        &with_light_paths(1.0, 4),
        &camera,
        &shape("rectangle", &[scale([1.5, 1.5, 1.0])], &diffuse(0.5)),
        &upright(30.0, 30.0, mirror, -90.0, &bsdf("conductor", "")),
        &upright(-4.0, 0.0, 20.0, 90.0, &diffuse(0.0)),
        &sphere([-30.0, 0.0, 90.0], LAMP, &area(1e6)),
    ])
}

/// The pixels at the edges of the film, in one row.
fn edges(image: &Image) -> Image {
    let size = SIZE as usize;
    let inner = 1..size - 1;
    let at_edge = |column: usize, row: usize| !inner.contains(&column) || !inner.contains(&row);
    chosen(image, (4 * (size - 1), 1), at_edge)
}

pub fn relations() -> Vec<Relation> {
    // A uniform image is the same through any filter, also at the edges, where filters are cut off. Over the
    // whole film wrong weights only move light about.
    let seen = |filter: &str| vec![Term { view: Some(edges), ..Term::new(floor(filter)) }];
    vec![Relation::expectation("edges_of_a_gaussian_film", seen("box"), seen("gaussian")).samples(3 * 65_536)]
}
