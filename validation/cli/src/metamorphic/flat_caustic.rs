//! An even caustic that hardly anything but light paths can find, so that whatever is wrong with these is seen in full.
//!
//! A flat mirror, upright beside the floor, throws the light of a small and far lamp upon it, and a screen keeps off what would
//! come straight. Of a hundred thousand camera paths one meets the lamp by the mirror.

use super::caustics::{with_integrator, with_light_paths};
use super::still_life::{INDEPENDENT, SIZE};
use super::{Relation, Term};
use crate::stage::*;

/// The lit floor from above through a reconstruction filter, with this besides.
fn floor(filter: &str, more: &str) -> String {
    // Seen from the floor the lamp's image stands as high as this, by its distance: a tenth.
    const HEIGHT: f64 = 9.0;
    let place = to_world(&[look_at([0.0, 0.0, 6.0], [0.0; 3], [0.0, 1.0, 0.0])]);
    let film = film(SIZE, SIZE).replace("<rfilter type=\"box\"/>", &format!("<rfilter type=\"{filter}\"/>"));
    let camera = format!("<sensor type=\"orthographic\">{place}{film}{INDEPENDENT}</sensor>");
    let upright = |x: f64, z: f64, size: [f64; 2], towards: f64, wears: &str| {
        let steps = [scale([size[0], size[1], 1.0]), rotate('y', towards), translate([x, 0.0, z])];
        shape("rectangle", &steps, wears)
    };
    scene(&[
        &with_light_paths(1.0, 4),
        &camera,
        &shape("rectangle", &[scale([1.5, 1.5, 1.0])], &diffuse(0.5)),
        &upright(30.0, HEIGHT / 3.0, [0.5, 1.3], -90.0, &bsdf("conductor", "")),
        &upright(-4.0, 0.0, [3.0, 3.0], 90.0, &diffuse(0.0)),
        &sphere([-30.0, 0.0, HEIGHT], 1.0, &area(1e5)),
        more,
    ])
}

pub fn relations() -> Vec<Relation> {
    let seen = |filter: &str, more: &str| vec![Term::new(floor(filter, more))];
    // What is even is the same through any filter, at the edges of the film as well.
    let filtered = |filter: &str| Relation::expectation(filter, seen("box", ""), seen(filter, ""));
    // A lamp that shines upwards, at the camera, which looks through it.
    let plate = shape("rectangle", &[scale([1.2, 1.2, 1.0]), translate([0.0, 0.0, 4.0])], &area(1.0));
    let hidden = Relation::expectation("behind_a_hidden_lamp", seen("box", ""), seen("box", &plate));
    let hidden = with_integrator(hidden, "<boolean name=\"hide_emitters\" value=\"true\"/></integrator>");
    [filtered("gaussian"), filtered("lanczos"), hidden].map(|relation| relation.samples(4096)).into()
}
