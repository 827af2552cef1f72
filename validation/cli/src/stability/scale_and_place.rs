//! Invariance under the unit of length and the position of the origin.

use super::Case;
use crate::metamorphic::still_life::{objects, placed, rough_metal};
use crate::metamorphic::{Relation, Term};
use crate::stage::*;

/// A function that returns objects, each moved by further transforms.
type Objects = fn(&[String]) -> Vec<String>;

/// Distance from the origin to the room's farthest corner.
const RADIUS: f64 = 4.5;

const VERTICES: &str = "vertices of meshes are f32 in world space: at 10⁵ radii from the origin a cube of 0.35 is known to 0.016. \
     The rows of `room` are the curve of error against distance; `round`, without meshes, keeps 7 digits.";

pub fn cases() -> Vec<Case> {
    let rooms: [(&str, Objects); 3] = [("room", objects), ("round", round), ("glass", glass)];
    let mut cases = vec![];
    let room = |objects: Objects, factor: f64, by: Point| placed(objects, factor, by);
    for (name, objects) in rooms {
        let plain = room(objects, 1.0, [0.0; 3]);
        for power in [-40, 40] {
            let other = Term::new(room(objects, libm::exp2(f64::from(power)), [0.0; 3]));
            let relation =
                Relation::bits(format!("{name}_times_2^{power}"), Term::new(plain.clone()), other).samples(8);
            cases.push(Case::alike("the same image, bit for bit", relation));
        }
        for power in [-6, -3, 3, 6] {
            let other = room(objects, libm::exp10(f64::from(power)), [0.0; 3]);
            let expectation = "the same image from the same numbers, but for rounding";
            let name = format!("{name}_times_10^{power}");
            cases.push(Case::same(name, expectation, [plain.clone(), other], 1e-3));
        }
        for power in 2..=5 {
            let far = RADIUS * libm::exp10(f64::from(power));
            let other = room(objects, 1.0, [0.8 * far, 0.53 * far, -0.28 * far]);
            let expectation = "the same image from the same numbers, so many radii from the origin";
            let case =
                Case::same(format!("{name}_moved_10^{power}"), expectation, [plain.clone(), other], 1e-3);
            // Half the distance between floats is 0.016 at 4.5·10⁵, 1/20 of the cube's half edge; the cube
            // and its shadow cover a tenth of the picture.
            cases.push(if name == "room" { case.limit(VERTICES, 5e-3) } else { case });
        }
    }
    cases
}

/// The objects without the cube, the only mesh: all others are stored in f64.
fn round(more: &[String]) -> Vec<String> {
    let mut objects = objects(more);
    objects.pop();
    objects
}

/// The objects with a ball of glass in place of the metal one.
fn glass(more: &[String]) -> Vec<String> {
    let glass = bsdf("dielectric", &float("int_ior", 1.5));
    round(more).into_iter().map(|object| object.replace(&rough_metal(), &glass)).collect()
}
