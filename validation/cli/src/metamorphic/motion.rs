//! The whole scene rotated, translated or mirrored.

use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;

pub fn relations() -> Vec<Relation> {
    let plain = || vec![Term::new(with(""))];
    let moved = |name: &str, steps: &[String]| {
        Relation::expectation(name, plain(), vec![Term::new(everything(steps))])
    };
    let flip = scale([-1.0, 1.0, 1.0]);
    let seen = look_at([-EYE[0], EYE[1], EYE[2]], [0.0, 0.0, 0.6], [0.0, 0.0, 1.0]);
    let lamp = shape("rectangle", &[lamp_steps(), vec![flip.clone()]].concat(), &area(8.0));
    let mirrored = scene(&[&path(4), &camera_at(&[seen]), &objects(&[flip]).concat(), &lamp]);
    // A mirrored closed shape is inside out, as in Mitsuba; here both sides have the same material.
    let both_sides = |text: &str| {
        let wears = [diffuse(0.3), diffuse(0.4), diffuse(0.6), diffuse(0.7), rough_metal()];
        wears.iter().fold(text.to_string(), |text, wears| text.replace(wears, &bsdf("twosided", wears)))
    };
    vec![
        moved("turned", &["<rotate x=\"1\" y=\"2\" z=\"-0.5\" angle=\"77\"/>".into()]),
        moved("moved", &[translate([3.7, -11.3, 5.9])]),
        moved("turned_and_moved", &[rotate('y', 123.0), translate([-2.0, 0.3, 41.0])]),
        Relation::expectation(
            "mirrored",
            vec![Term::new(both_sides(&with("")))],
            vec![Term { mirrored: true, ..Term::new(both_sides(&mirrored)) }],
        ),
    ]
}

/// Objects, lamp and camera under the same transforms.
fn everything(steps: &[String]) -> String {
    let place = [vec![look_at(EYE, [0.0, 0.0, 0.6], [0.0, 0.0, 1.0])], steps.to_vec()].concat();
    let lamp = shape("rectangle", &[lamp_steps(), steps.to_vec()].concat(), &area(8.0));
    scene(&[&path(4), &camera_at(&place), &objects(steps).concat(), &lamp])
}
