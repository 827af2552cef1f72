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
        sun_upon_waves(),
        Relation::expectation("smooth_lamp", room(&faceted_lamp(false)), room(&faceted_lamp(true))),
        Relation::expectation("unlit_lamp", whole(), room(&(lamp(8.0) + &point_light(1.0, 0.0)))),
    ]
}

/// The sun as a camera below rough water sees it, which only emitter samples find: dark water takes as much of it as lies
/// between the camera and the surface, and nothing beyond.
fn sun_upon_waves() -> Relation {
    const SIGMA: f64 = 0.4;
    let towards = [0.2, 0.1, 1.0];
    let depth = towards.iter().map(|x| x * x).sum::<f64>().sqrt();
    let water = |name: &str| {
        let parameters = float("sigma_t", SIGMA) + &float("albedo", 0.0);
        format!("<medium type=\"homogeneous\" name=\"{name}\">{parameters}</medium>")
    };
    let rough = float("alpha", 0.3) + &float("int_ior", 1.33) + &float("ext_ior", 1.0);
    let surface = |interior: &str| {
        let wears = bsdf("roughdielectric", &rough) + interior;
        shape("rectangle", &[scale([9.0; 3]), translate([0.0, 0.0, 1.0])], &wears)
    };
    let camera = |medium: &str| {
        let place = look_at([0.0; 3], towards, [0.0, 1.0, 0.0]);
        pinhole(&place, 0.5, &(film(4, 4) + INDEPENDENT + medium))
    };
    let sun = |irradiance: f64| {
        let down = "<vector name=\"direction\" x=\"0.1\" y=\"0.2\" z=\"-1\"/>".to_string();
        emitter("directional", &(down + &grey("irradiance", irradiance)))
    };
    let volpath = "<integrator type=\"volpath\"><integer name=\"max_depth\" value=\"2\"/></integrator>";
    let clear = scene(&[volpath, &camera(""), &surface(""), &sun(libm::exp(-SIGMA * depth))]);
    let dark = scene(&[volpath, &camera(&water("medium")), &surface(&water("interior")), &sun(1.0)]);
    Relation::expectation("sun_upon_waves", vec![Term::new(clear)], vec![Term::new(dark)])
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
