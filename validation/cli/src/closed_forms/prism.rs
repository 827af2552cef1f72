//! The minimum deviation of a prism.

use super::ClosedForm;
use super::interfaces::reflectance;
use crate::stage::*;

pub fn cases() -> Vec<ClosedForm> {
    let source =
        "least deviation D: sin((A + D)/2) = n sin(A/2) (Born & Wolf, eq. 4.7.9), times Fresnel's (1 − R)²";
    let case = |eta: f64, offset: f64| {
        let (scene, expected) = prism(eta, offset);
        ClosedForm::new(format!("least_deviation_{eta}_{offset}"), source, scene, expected)
            .margin(0.0025)
            .samples(1 << 17)
    };
    vec![case(1.5, 0.0), case(1.5, 0.3), case(1.7, -0.4)]
}

/// Half the width of the beam.
const BEAM: f64 = 0.01;
/// Distance of the light behind the prism: 10⁻³ of the beam is 5·10⁻⁷ rad.
const DISTANCE: f64 = 20.0;

/// A parallel beam through two faces with an apex angle of 60° between them, onto a half-plane of light whose
/// edge is `offset` half-widths from where the centre of the beam must arrive. At minimum deviation the beam
/// keeps its width.
///
/// The apex points to +z, the faces are symmetric about x = 0, and the ray inside runs along +x at z = 0.
fn prism(eta: f64, offset: f64) -> (String, f64) {
    const APEX: f64 = 60.0;
    let half = f64::to_radians(0.5 * APEX);
    // Inside, the ray makes the angle A/2 with both normals; outside (A + D)/2.
    let outside = libm::asin(eta * libm::sin(half));
    let bend = outside - half;
    let (sin, cos) = libm::sincos(bend);
    // Faces through (∓1, 0) with outward normals at A/2 above ∓x.
    let glass = bsdf("dielectric", &(float("int_ior", eta) + &float("ext_ior", 1.0)));
    let face = |sign: f64| {
        let steps = [scale([0.5; 3]), rotate('y', sign * (90.0 - 0.5 * APEX)), translate([sign, 0.0, 0.0])];
        shape("rectangle", &steps, &glass)
    };
    // The beam rises towards −x and descends behind +x, deviated by D = 2·bend towards the base.
    let (from, to) = ([-1.0 - 5.0 * cos, 0.0, -5.0 * sin], [-1.0, 0.0, 0.0]);
    let place = to_world(&[scale([BEAM, BEAM, 1.0]), look_at(from, to, [0.0, 1.0, 0.0])]);
    let camera = format!("<sensor type=\"orthographic\">{place}{}</sensor>", film(1, 1));
    // The light faces the beam; its local y is the world's, its local x lies across the beam.
    let onto = [1.0 + DISTANCE * cos, 0.0, -DISTANCE * sin];
    let wide = 5.0;
    let steps = [
        translate([1.0, 0.0, 0.0]),
        scale([wide, wide, 1.0]),
        translate([offset * BEAM, 0.0, 0.0]),
        look_at([0.0; 3], [-cos, 0.0, sin], [0.0, 1.0, 0.0]),
        translate(onto),
    ];
    let light = shape("rectangle", &steps, &area(1.0));
    let r = reflectance(outside.to_degrees(), eta);
    let expected = (1.0 - r) * (1.0 - r) * 0.5 * (1.0 - offset);
    (scene(&[&path(-1), &camera, &face(-1.0), &face(1.0), &light]), expected)
}
