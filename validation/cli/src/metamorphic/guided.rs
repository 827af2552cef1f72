//! Guided emitter samples change the noise and nothing else, whatever is on the way and however many surfaces.

use super::Relation;
use super::caustics::{ball, block, glass, plain, room, vase, with_integrator, with_light_paths};
use super::still_life::*;
use super::{Term, reuse};
use crate::stage::*;

fn guided(integrator: &str) -> String {
    integrator.replace("</integrator>", "<string name=\"links\" value=\"guided\"/></integrator>")
}

/// At all vertices without light paths, with them where they cannot help.
fn relation(name: &str, share: f64, things: &str) -> Relation {
    up_to(6, name, share, things)
}

fn up_to(longest: i64, name: &str, share: f64, things: &str) -> Relation {
    let side = |integrator: String| vec![Term::new(scene(&[&integrator, &camera(), &room(things)]))];
    Relation::expectation(name, side(plain(longest)), side(guided(&with_light_paths(share, longest))))
        .samples(4096)
}

pub fn relations() -> Vec<Relation> {
    let clear = || glass("");
    let metal = || bsdf("conductor", "<string name=\"material\" value=\"none\"/>");
    let sheet = shape(
        "rectangle",
        &[scale([1.0; 3]), rotate('y', -60.0), translate([1.6, 0.3, 1.0])],
        &bsdf("twosided", &metal()),
    );
    let globe = sphere([-0.5, 0.0, 1.0], 0.25, &area(4.0)) + &sphere([-0.5, 0.0, 1.0], 0.6, &clear());
    let within = sphere([-0.5, 0.0, 0.8], 0.7, &clear()) + &sphere([-0.5, 0.0, 0.8], 0.4, &diffuse(0.6));
    let plastic = bsdf("plastic", &grey("diffuse_reflectance", 0.5));
    let dull = sphere([0.9, -0.3, 0.4], 0.4, &bsdf("roughplastic", &float("alpha", 0.2)));
    let veil = shape(
        "rectangle",
        &[scale([0.6, 0.6, 1.0]), rotate('x', 90.0), translate([0.3, -1.5, 0.8])],
        &format!("<bsdf type=\"mask\">{}{}</bsdf>", float("opacity", 0.5), diffuse(0.4)),
    );
    // All light from the lamp comes by two surfaces.
    let slab = shape("cube", &[scale([2.9, 2.9, 0.1]), translate([0.0, 0.0, 1.9])], &clear());
    // Emitters that light goes through and is reflected by.
    let shining = sphere([0.9, -0.3, 0.4], 0.4, &(clear() + &area(0.5)));
    let four = "<integer name=\"emitter_samples\" value=\"4\"/></integrator>";
    let flint = "<bsdf type=\"dielectric\"><string name=\"dispersion\" value=\"sf11\"/></bsdf>";
    vec![
        relation("glass_and_metal", 0.0, &(block(&clear()) + &ball(&metal()) + &sheet)),
        relation("glass_and_metal_and_light_paths", 1.0, &(block(&metal()) + &ball(&clear()) + &sheet)),
        relation("bulb", 0.0, &(globe.clone() + &sheet)),
        relation("matte_within_glass", 1.0, &within),
        relation("vase", 0.0, &(vase(&clear()) + &dull)),
        relation(
            "plastic_and_a_veil",
            0.0,
            &(globe.clone() + &veil + &sphere([0.9, -0.3, 0.4], 0.4, &plastic)),
        ),
        relation("glass_that_shines", 0.0, &(shining + &ball(&metal()))),
        with_integrator(relation("four_samples", 0.0, &globe), four).at_length(),
        relation("slab", 0.0, &slab),
        up_to(3, "one_edge_too_far", 0.0, &ball(&clear())),
        up_to(4, "no_edge_too_far", 0.0, &ball(&clear())),
        relation("dispersion", 0.0, &(block(flint) + &ball(&metal()))).in_spectra(),
        reuse::shared("path_re_use", &guided(&path(6)), &(globe + &sheet)),
    ]
}
