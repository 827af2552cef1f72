//! Extreme fields of view, lenses and focus distances.

use super::Case;
use crate::closed_forms::ClosedForm;
use crate::metamorphic::still_life::{camera, lamp, objects};
use crate::stage::*;
use std::f64::consts::PI;

pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = answers().into_iter().map(Case::answer).collect();
    let room = |sensor: String| scene(&[&path(4), &sensor, &objects(&[]).concat(), &lamp(8.0)]);
    for (name, radius) in [("lens_of_nothing", 0.0), ("lens_of_1e-9", 1e-9)] {
        let lens = float("aperture_radius", radius) + &float("focus_distance", 4.0);
        let thin = camera().replace("\"perspective\">", &format!("\"thinlens\">{lens}"));
        let expectation = "a lens of no width is a pinhole, from the same numbers";
        cases.push(Case::same(name, expectation, [room(camera()), room(thin)], 1e-3));
    }
    cases
}

fn answers() -> Vec<ClosedForm> {
    let place = look_at([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    let square = |half: f64, depth: f64| {
        shape("rectangle", &[scale([half; 3]), rotate('x', 180.0), translate([0.0, 0.0, depth])], &area(1.0))
    };
    let share = "a square of 0.3 of the film's half-width fills 0.09 of it";
    let mut cases = vec![];
    for degrees in [1e-3, 1.0, 179.0, 179.9] {
        let half = libm::tan(f64::to_radians(0.5 * degrees));
        let scene = scene(&[&path(1), &pinhole(&place, degrees, &film(6, 6)), &square(0.3 * half, 1.0)]);
        cases.push(ClosedForm::new(format!("fov_{degrees:e}"), share, scene, 0.09).samples(1 << 14));
    }
    let thin = |degrees: f64, film: &str, lens: (f64, f64)| {
        let lens =
            float("aperture_radius", lens.0) + &float("focus_distance", lens.1) + &float("far_clip", 1e12);
        pinhole(&place, degrees, film).replace("\"perspective\">", &format!("\"thinlens\">{lens}"))
    };
    let half = libm::tan(f64::to_radians(20.0));
    for (name, radius, focus, depth) in
        [("lens_of_1e3", 1e3, 1.0, 1.0), ("focus_at_infinity", 0.2, 1e30, 1e8)]
    {
        let scene =
            scene(&[&path(1), &thin(40.0, &film(6, 6), (radius, focus)), &square(0.3 * half * depth, depth)]);
        cases.push(ClosedForm::new(name, share, scene, 0.09).samples(1 << 14));
    }
    let blur = 0.2 * (1.0f64 / 0.01 - 1.0);
    let edge = [scale([1000.0; 3]), rotate('x', 180.0), translate([1000.0 + 0.3 * blur, 0.0, 1.0])];
    let scene =
        scene(&[&path(1), &thin(1e-4, &film(1, 1), (0.2, 0.01)), &shape("rectangle", &edge, &area(1.0))]);
    let source = "segment of the circle of confusion: (acos t − t√(1 − t²))/π, focus at the near plane";
    let expected = (libm::acos(0.3) - 0.3 * (1.0f64 - 0.09).sqrt()) / PI;
    cases.push(ClosedForm::new("focus_at_the_near_plane", source, scene, expected).samples(1 << 14));
    cases
}
