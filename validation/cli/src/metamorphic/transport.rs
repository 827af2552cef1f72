//! Exchange of camera and light.
//!
//! An orthographic camera in direction a integrates the radiance that leaves the scene towards a over the
//! area of its beam; light from direction b illuminates all of the scene. By reciprocity of every bounce the
//! integral is the same with the camera at b and the light at a (Veach 1997, §4.6), provided that both beams
//! contain the whole scene.

use super::{Relation, Term};
use crate::stage::*;

pub fn relations() -> Vec<Relation> {
    let metal = bsdf("roughconductor", &(float("alpha", 0.6) + &float("eta", 0.2) + &float("k", 3.0)));
    let frosted =
        bsdf("roughdielectric", &(float("alpha", 0.6) + &float("int_ior", 1.5) + &float("ext_ior", 1.0)));
    let satin =
        bsdf("roughplastic", &(float("alpha", 0.3) + &float("int_ior", 1.5) + &float("ext_ior", 1.0)));
    let wears = [("matte", diffuse(0.8)), ("metal", metal), ("frosted_glass", frosted), ("plastic", satin)];
    wears
        .into_iter()
        .map(|(name, wears)| {
            let (a, b) = ([0.3, -2.0, 1.0], [1.5, -0.7, 0.8]);
            let view = |from, lit| vec![Term::new(exchange(from, lit, &wears))];
            Relation::expectation(format!("exchanged_{name}"), view(a, b), view(b, a))
                .of_means()
                .samples(1 << 15)
        })
        .collect()
}

/// Three bodies that illuminate and shadow each other, within the unit ball, seen from one direction and lit
/// from another.
fn exchange(view: Point, light: Point, wears: &str) -> String {
    let from = view.map(|v| v * 3.0);
    let place = to_world(&[look_at(from, [0.0; 3], [0.0, 0.0, 1.0])]);
    let film = film(8, 8) + super::still_life::INDEPENDENT;
    let camera = format!("<sensor type=\"orthographic\">{place}{film}</sensor>");
    let [x, y, z] = light.map(|v| -v);
    let direction = format!("<vector name=\"direction\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
    let light = emitter("directional", &(direction + &grey("irradiance", 3.0)));
    let bodies = sphere([-0.4, 0.1, 0.0], 0.45, wears)
        + &sphere([0.4, -0.3, 0.1], 0.35, &diffuse(0.7))
        + &shape(
            "cube",
            &[scale([0.5, 0.4, 0.05]), rotate('x', 10.0), translate([0.0, 0.0, -0.5])],
            &diffuse(0.6),
        );
    scene(&[&path(4), &camera, &bodies, &light])
}
