//! Superposition and subdivision of lights.

use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;

pub fn relations() -> Vec<Relation> {
    let whole = || vec![Term::new(with(""))];
    let room = |lights: &str| vec![Term::new(with_light(lights))];
    let quarters: String = [(-0.35, -0.35), (0.35, -0.35), (-0.35, 0.35), (0.35, 0.35)]
        .map(|(x, y)| {
            let steps = [scale([0.35, 0.35, 1.0]), rotate('x', 180.0), translate([x, y, 2.5])];
            shape("rectangle", &steps, &area(8.0))
        })
        .concat();
    let sky = constant(0.5);
    vec![
        Relation::expectation("quarters", whole(), room(&quarters)),
        Relation::expectation(
            "superposition_areas",
            [room(&(lamp(8.0) + &side_lamp(0.0))), room(&(lamp(0.0) + &side_lamp(6.0)))].concat(),
            room(&(lamp(8.0) + &side_lamp(6.0))),
        ),
        Relation::expectation(
            "superposition_lamp_and_sky",
            [room(&lamp(8.0)), room(&(lamp(0.0) + &sky))].concat(),
            room(&(lamp(8.0) + &sky)),
        ),
        Relation::expectation(
            "superposition_points",
            [room(&point_light(-1.0, 3.0)), room(&point_light(1.0, 2.0))].concat(),
            room(&(point_light(-1.0, 3.0) + &point_light(1.0, 2.0))),
        ),
        Relation::expectation(
            "two_in_one_place",
            room(&point_light(0.5, 5.0)),
            room(&(point_light(0.5, 2.0) + &point_light(0.5, 3.0))),
        ),
        Relation::expectation("linear", vec![Term::new(with("")).times(0.3)], room(&lamp(2.4))),
        Relation::expectation("smooth_lamp", room(&faceted_lamp(false)), room(&faceted_lamp(true))),
        Relation::expectation("unlit_lamp", whole(), room(&(lamp(8.0) + &point_light(1.0, 0.0)))),
    ]
}

/// A luminous octahedron, smooth or with flat faces: which side of a face emits does not depend on its
/// shading normal, which points away from most points that see the face at a grazing angle.
fn faceted_lamp(flat: bool) -> String {
    let mesh = format!(
        "<string name=\"filename\" value=\"meshes/octahedron.ply\"/><boolean name=\"face_normals\" value=\"{flat}\"/>"
    );
    shape(
        "ply",
        &[scale([0.6; 3]), rotate('y', 20.0), rotate('x', 50.0), translate([0.9, -0.5, 1.0])],
        &(mesh + &diffuse(0.0) + &area(4.0)),
    )
}

/// A lamp at the left, outside of the view. Unlit it still casts shadows.
fn side_lamp(radiance: f64) -> String {
    shape("rectangle", &[scale([0.5; 3]), rotate('y', 90.0), translate([-2.6, -0.5, 1.0])], &area(radiance))
}
