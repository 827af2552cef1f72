//! Relations of emitter samples by mirrors: they change the noise only, whatever the mirror and its
//! reflection are.

use super::Relation;
use super::caustics::{ball, block, glass, globe, room, sheet, with_integrator};
use super::through_glass::{relation, up_to};
use crate::stage::*;

pub fn relations() -> Vec<Relation> {
    let metal = || bsdf("conductor", "<string name=\"material\" value=\"none\"/>");
    let disk = |wears: &str| {
        shape("disk", &[scale([0.8; 3]), rotate('x', 70.0), translate([-0.6, 1.0, 0.9])], wears)
    };
    let turned = ball(&metal()).replace("<bsdf", "<boolean name=\"flip_normals\" value=\"true\"/><bsdf");
    let twosided = bsdf("twosided", &metal());
    let tinted = bsdf("conductor", "<rgb name=\"specular_reflectance\" value=\"0.9, 0.5, 0.2\"/>");
    let squares = bsdf(
        "conductor",
        "<texture type=\"checkerboard\" name=\"specular_reflectance\"><float name=\"color0\" value=\"0.2\"/><float name=\"color1\" value=\"0.9\"/></texture>",
    );
    // The lamp illuminates the sheet only.
    let hidden =
        shape("rectangle", &[scale([0.25; 3]), rotate('y', 90.0), translate([0.2, 0.3, 1.3])], &area(20.0));
    let within = sphere([-0.5, 0.0, 0.8], 0.7, &glass("")) + &sphere([-0.5, 0.0, 0.8], 0.3, &metal());
    let rough_floor = shape(
        "rectangle",
        &[scale([3.0, 3.0, 1.0]), translate([0.0, 0.0, 0.02])],
        &bsdf("roughconductor", &float("alpha", 0.3)),
    );
    let embedded =
        block(&glass("")) + &shape("cube", &[scale([0.15; 3]), translate([0.8, 0.2, 0.5])], &diffuse(0.6));
    let four = "<integer name=\"emitter_samples\" value=\"4\"/></integrator>";
    vec![
        relation("ball", 0.0, &ball(&metal())).longer(2),
        relation("ball_and_light_paths", 1.0, &ball(&metal())),
        relation("ball_of_glass", 1.0, &ball(&glass(""))).at_length(),
        relation("hollow_ball", 1.0, &turned).samples(1024),
        relation("sheet", 0.0, &sheet(&metal())).samples(1024),
        relation("sheet_and_light_paths", 1.0, &sheet(&metal())),
        relation("back_of_a_sheet", 1.0, &sheet(&twosided).replace("-60", "120")).samples(1024),
        relation("disk", 1.0, &disk(&tinted)),
        relation("squares", 1.0, &sheet(&squares)),
        relation("block", 1.0, &block(&metal())).samples(1024),
        relation("lamp_that_is_not_seen", 0.0, &(hidden.clone() + &sheet(&metal())))
            .samples(16384)
            .at_length(),
        relation("lamp_that_is_not_seen_and_light_paths", 1.0, &(hidden + &sheet(&metal()))).samples(2048),
        relation("two_mirrors", 1.0, &(ball(&metal()) + &sheet(&metal()))).at_length(),
        relation(
            "many_mirrors",
            0.0,
            &(ball(&metal()) + &sheet(&metal()) + &disk(&tinted) + &block(&metal())),
        ),
        relation("bulb_before_a_sheet", 1.0, &(globe() + &sheet(&metal()))).at_length(),
        relation("metal_within_glass", 1.0, &within).at_length(),
        relation("matte_within_a_block", 1.0, &embedded).samples(16384).at_length(),
        relation("upon_rough_metal", 1.0, &(ball(&metal()) + &rough_floor)).samples(2048),
        with_integrator(relation("four_samples", 1.0, &(ball(&metal()) + &sheet(&metal()))), four)
            .at_length(),
        // By way of the mirror the lamp is two edges from the floor, and the camera a third.
        up_to(2, "one_edge_too_far", 0.0, &room(&ball(&metal()))),
        up_to(3, "no_edge_too_far", 1.0, &room(&ball(&metal()))).longer(2),
        relation(
            "in_spectra",
            1.0,
            &(ball(&bsdf("conductor", "<string name=\"material\" value=\"Cu\"/>")) + &sheet(&metal())),
        )
        .in_spectra()
        .at_length(),
        relation(
            "dispersion",
            1.0,
            &block("<bsdf type=\"dielectric\"><string name=\"dispersion\" value=\"sf11\"/></bsdf>"),
        )
        .in_spectra(),
    ]
}
