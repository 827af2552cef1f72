//! Lights without extent.

use super::ClosedForm;
use super::irradiance::{floor_under, shown};
use crate::stage::*;
use std::f64::consts::PI;

pub fn cases() -> Vec<ClosedForm> {
    let source = "E = I cos θ / d²";
    let point = "<point name=\"position\" x=\"0.3\" y=\"0.4\" z=\"1.2\"/>";
    let point = emitter("point", &(point.to_string() + &grey("intensity", 2.0)));
    let d2: f64 = 0.3 * 0.3 + 0.4 * 0.4 + 1.2 * 1.2;
    let directional = "<vector name=\"direction\" x=\"-2\" y=\"-1\" z=\"-2\"/>";
    let directional = emitter("directional", &(directional.to_string() + &grey("irradiance", 3.0)));
    let mut cases = vec![
        ClosedForm::new("point", source, floor_under(&point), shown(2.0 * 1.2 / (d2 * d2.sqrt()))),
        ClosedForm::new("directional", "E = E₀ cos θ", floor_under(&directional), shown(3.0 * 2.0 / 3.0)),
    ];
    for (name, target) in [("spot_beam", 0.1), ("spot_fading", 0.4)] {
        let source =
            "I(θ) = I (cutoff − θ)/(cutoff − beam) between the angles (Mitsuba's definition of `spot`)";
        cases.push(ClosedForm::new(name, source, floor_under(&spot(target)), shown(spot_answer(target))));
    }
    for (name, target) in [("projector", [0.6, 0.0, 0.0]), ("projector_aslant", [0.1, -0.1, 0.0])] {
        let source = "E = πE₁ h/z³ at height h below a projector, z along its axis (Mitsuba's definition)";
        let answer = shown(projector_answer(target));
        cases.push(ClosedForm::new(name, source, floor_under(&projector(target)), answer));
    }
    for degrees in [0.0, 30.0, 60.0] {
        let source = "E = LA cos⁴θ / h² of a small lamp parallel to the plane (the cos⁴ law)";
        let scene = floor_under(&lamp(degrees));
        let cos = libm::cos(f64::to_radians(degrees));
        // The next term of the expansion in r/h is (r/h)²: 6e-6.
        let expected = PI * LAMP * LAMP * cos * cos * cos * cos;
        cases.push(ClosedForm::new(format!("cos4_{degrees}"), source, scene, shown(expected)));
    }
    cases
}

/// Position above (0.6, 0), cutoff angle and beam width in degrees of a spot directed at a point of the
/// floor.
const SPOT: (Point, f64, f64) = ([0.6, 0.0, 1.5], 20.0, 5.0);

fn spot(target: f64) -> String {
    let (place, cutoff, beam) = SPOT;
    let turn = to_world(&[look_at(place, [target, 0.0, 0.0], [0.0, 1.0, 0.0])]);
    let angles = float("cutoff_angle", cutoff) + &float("beam_width", beam);
    emitter("spot", &(grey("intensity", 2.0) + &angles + &turn))
}

/// In the plane y = 0 angles are differences of arctangents.
fn spot_answer(target: f64) -> f64 {
    let ([x, _, z], cutoff, beam) = SPOT;
    let angle = (libm::atan2(x, z) - libm::atan2(x - target, z)).to_degrees();
    let fade = ((cutoff - angle) / (cutoff - beam)).clamp(0.0, 1.0);
    let d2 = x * x + z * z;
    2.0 * fade * z / (d2 * d2.sqrt())
}

/// Position, E₁ and the factor `scale` of a projector that throws an even picture at a point of the floor.
const PROJECTOR: (Point, f64, f64) = ([0.6, 0.0, 1.5], 0.4, 2.0);

fn projector(target: Point) -> String {
    let (place, irradiance, factor) = PROJECTOR;
    let turn = to_world(&[look_at(place, target, [0.0, 1.0, 0.0])]);
    emitter(
        "projector",
        &(grey("irradiance", irradiance) + &float("scale", factor) + &float("fov", 60.0) + &turn),
    )
}

/// At the origin.
fn projector_answer(target: Point) -> f64 {
    let (place, irradiance, factor) = PROJECTOR;
    let axis = [0, 1, 2].map(|i| target[i] - place[i]);
    let product = |a: Point, b: Point| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let along = product(axis, place.map(|x| -x)) / product(axis, axis).sqrt();
    PI * irradiance * factor * place[2] / (along * along * along)
}

/// Radius of a lamp at height 1.
const LAMP: f64 = 0.0025;

fn lamp(degrees: f64) -> String {
    let place = translate([libm::tan(degrees.to_radians()), 0.0, 1.0]);
    shape("disk", &[scale([LAMP; 3]), rotate('x', 180.0), place], &area(1.0))
}

#[cfg(test)]
mod tests {
    #[test]
    fn one_spot_is_in_the_beam_and_one_fades() {
        let full = super::spot_answer(0.0);
        assert_eq!(super::spot_answer(0.1), full);
        let share = super::spot_answer(0.4) / full;
        assert!((0.2..0.9).contains(&share), "{share}");
    }
}
