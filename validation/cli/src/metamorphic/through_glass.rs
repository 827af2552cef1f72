//! Relations of emitter samples through glass: they change the noise only, whatever the glass, the surface
//! and the emitter behind it.

use super::Relation;
use super::caustics::{
    as_plain, ball, block, glass, half_open, room, sheet, two_sided, vase, veil, with_integrator,
    with_light_paths, with_links, within,
};
use super::still_life::*;
use crate::stage::*;

/// The relation for emitter samples at all vertices, with `share` light paths per camera path, in the room
/// with these objects.
pub(super) fn relation(name: &str, share: f64, things: &str) -> Relation {
    up_to(6, name, share, &room(things))
}

pub(super) fn up_to(longest: i64, name: &str, share: f64, world: &str) -> Relation {
    let everywhere = with_links(&with_light_paths(share, longest), "everywhere");
    as_plain(name, longest, everywhere, (&camera(), world))
}

/// A floor under a pane and under a lamp so large that its coordinates are a thousand times those of its
/// relevant points.
fn lamp_past_the_origin() -> Relation {
    let floor = shape("rectangle", &[], &diffuse(0.5));
    let face = |steps: &[String]| shape("rectangle", &[&[scale([40.0; 3])], steps].concat(), &glass(""));
    let pane =
        face(&[translate([0.0, 0.0, 0.5])]) + &face(&[rotate('x', 180.0), translate([0.0, 0.0, 0.45])]);
    let lamp = sphere([0.0, 0.0, 1001.0], 1000.0, &area(1.0));
    let place = look_at([0.0, 0.0, 0.4], [0.0; 3], [0.0, 1.0, 0.0]);
    let camera = pinhole(&place, 40.0, &(film(8, 8) + INDEPENDENT));
    let links = with_links(&with_light_paths(0.0, 6), "everywhere");
    as_plain("lamp_past_the_origin", 6, links, (&camera, &(floor + &pane + &lamp)))
}

pub fn relations() -> Vec<Relation> {
    let clear = || glass("");
    let bulb = sphere([-0.5, 0.0, 1.0], 0.3, &area(3.0)) + &sphere([-0.5, 0.0, 1.0], 0.6, &clear());
    let globe = sphere([-0.5, 0.0, 1.0], 0.25, &area(4.0))
        + &sphere([-0.5, 0.0, 1.0], 0.6, &clear())
        + &sphere(
            [-0.5, 0.0, 1.0],
            0.5,
            &bsdf("dielectric", &(float("int_ior", 1.0) + &float("ext_ior", 1.5))),
        );
    let pane = |wears: &str| shape("rectangle", &[scale([1.2, 1.2, 1.0]), translate([0.0, 0.0, 1.8])], wears);
    // A screen between the pane and the lamp.
    let screen = shape("rectangle", &[scale([0.5, 0.5, 1.0]), translate([0.2, 0.0, 2.1])], &diffuse(0.2));
    // Where the straight line to the lamp passes between slats the refracted path meets one, and vice versa.
    let slats = |wears: &str| {
        let slat = |i: i32| {
            let steps = [scale([1.5, 0.06, 1.0]), translate([0.0, -0.3 + 0.25 * f64::from(i), 1.95])];
            shape("rectangle", &steps, wears)
        };
        (-6..7).map(slat).collect::<String>()
    };
    let slab = |wears: &str| shape("cube", &[scale([2.9, 2.9, 0.4]), translate([0.0, 0.0, 1.4])], wears);
    let matte_slats = slats(&bsdf("twosided", &diffuse(0.2)));
    // They do not bend light: only their number tells a way through one from a way between them.
    let clear_slats = slats(&bsdf("thindielectric", ""));
    let dense = slab(&bsdf("dielectric", &float("int_ior", 2.2)));
    let tube = shape(
        "cylinder",
        &[translate([-0.5, 0.0, 0.0])],
        &("<point name=\"p0\" x=\"-0.8\" y=\"0\" z=\"0.9\"/><point name=\"p1\" x=\"0.8\" y=\"0\" z=\"0.9\"/>"
            .to_owned()
            + &float("radius", 0.4) + &clear()),
    );
    let mirror = sheet(&bsdf("conductor", ""));
    let floor =
        |wears: &str| shape("rectangle", &[scale([3.0, 3.0, 1.0]), translate([0.0, 0.0, 0.02])], wears);
    let rough = |kind: &str, more: &str| floor(&bsdf(kind, &(float("alpha", 0.3) + more)));
    let one_way = two_sided(&(diffuse(0.7) + &half_open(0.5)));
    let schlick = glass("<string name=\"fresnel\" value=\"schlick\"/>");
    let second = sphere([1.0, -0.5, 1.6], 0.3, &area(12.0));
    let four = "<integer name=\"emitter_samples\" value=\"4\"/></integrator>";
    vec![
        relation("glass_ball", 0.0, &ball(&clear())),
        relation("glass_ball_and_light_paths", 1.0, &ball(&clear())).at_length(),
        relation("bulb", 0.0, &bulb),
        relation("bulb_and_light_paths", 1.0, &bulb),
        relation("bulb_in_a_globe", 0.0, &globe).at_length(),
        relation("bulb_in_a_globe_and_light_paths", 1.0, &globe).at_length(),
        relation("seen_in_a_mirror", 1.0, &(globe.clone() + &mirror)).at_length(),
        relation("matte_within_glass", 1.0, &within()),
        relation("thin_pane", 0.0, &pane(&bsdf("thindielectric", ""))).longer(2),
        relation("screen_above_a_pane", 0.0, &(pane(&bsdf("thindielectric", "")) + &screen))
            .longer(3)
            .at_length(),
        relation("slats_above_a_slab", 0.0, &(slab(&clear()) + &matte_slats)).within(0.05),
        relation("clear_slats_above_a_slab", 0.0, &(dense + &clear_slats)).within(0.05),
        relation("thin_pane_and_light_paths", 1.0, &pane(&bsdf("thindielectric", ""))).at_length(),
        relation("surface_of_water", 1.0, &pane(&clear())).samples(16384).at_length(),
        relation("block", 0.0, &block(&clear())),
        relation("block_and_light_paths", 1.0, &block(&clear())).at_length(),
        relation("tinted_block", 1.0, &block(&glass(&grey("specular_transmittance", 0.6)))).at_length(),
        relation("schlick", 1.0, &ball(&schlick)).at_length(),
        relation("vase", 0.0, &vase(&clear())),
        relation("vase_and_light_paths", 1.0, &vase(&clear())).at_length(),
        relation("tube", 1.0, &tube).at_length(),
        relation("ball_in_a_block", 1.0, &(block(&clear()) + &sphere([0.8, 0.2, 0.55], 0.3, &clear())))
            .at_length(),
        relation("upon_rough_metal", 1.0, &(globe.clone() + &rough("roughconductor", ""))).at_length(),
        relation(
            "upon_rough_plastic",
            1.0,
            &(globe.clone() + &rough("roughplastic", &grey("diffuse_reflectance", 0.5))),
        )
        .at_length(),
        relation("upon_what_has_two_sides", 1.0, &(ball(&clear()) + &floor(&one_way))),
        relation("two_sided_glass", 1.0, &ball(&two_sided(&clear()))),
        // Light paths are aimed at the inner ball, and cannot reach it.
        relation(
            "glass_in_two_sided_glass",
            1.0,
            &(ball(&two_sided(&clear())) + &sphere([-0.5, 0.0, 0.7], 0.35, &clear())),
        ),
        relation("two_lamps", 1.0, &(ball(&clear()) + &second)).at_length(),
        relation("behind_a_veil", 1.0, &(globe.clone() + &veil())).at_length(),
        with_integrator(relation("four_samples", 1.0, &globe), four).at_length(),
        // Through the glass the lamp is two edges from the floor, and the camera a third.
        up_to(3, "one_edge_too_far", 0.0, &room(&ball(&clear()))),
        up_to(4, "no_edge_too_far", 1.0, &room(&ball(&clear()))).at_length(),
        lamp_past_the_origin(),
        relation("in_spectra", 1.0, &globe).in_spectra().at_length(),
        relation(
            "dispersion",
            1.0,
            &block("<bsdf type=\"dielectric\"><string name=\"dispersion\" value=\"sf11\"/></bsdf>"),
        )
        .in_spectra(),
    ]
}
