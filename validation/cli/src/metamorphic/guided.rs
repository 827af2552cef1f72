//! Relations of guided emitter samples: they change the noise only, whatever lies between and however many
//! surfaces.

use super::caustics::{
    as_plain, ball, block, glass, globe, room, sheet, vase, veil, with_integrator, with_light_paths,
    with_links, within,
};
use super::still_life::*;
use super::{Relation, reuse};
use crate::stage::*;

/// Guided samples at all vertices without light paths, and with light paths at the vertices where these do
/// not help.
fn relation(name: &str, share: f64, things: &str) -> Relation {
    up_to(6, name, share, things)
}

fn up_to(longest: i64, name: &str, share: f64, things: &str) -> Relation {
    let guided = with_links(&with_light_paths(share, longest), "guided");
    as_plain(name, longest, guided, (&camera(), &room(things)))
}

pub fn relations() -> Vec<Relation> {
    let clear = || glass("");
    let metal = || bsdf("conductor", "<string name=\"material\" value=\"none\"/>");
    let sheet = sheet(&bsdf("twosided", &metal()));
    let plastic = bsdf("plastic", &grey("diffuse_reflectance", 0.5));
    let dull = sphere([0.9, -0.3, 0.4], 0.4, &bsdf("roughplastic", &float("alpha", 0.2)));
    // All light from the lamp passes two surfaces.
    let slab = shape("cube", &[scale([2.9, 2.9, 0.1]), translate([0.0, 0.0, 1.9])], &clear());
    // An emitter that also transmits and reflects light.
    let shining = sphere([0.9, -0.3, 0.4], 0.4, &(clear() + &area(0.5)));
    let four = "<integer name=\"emitter_samples\" value=\"4\"/></integrator>";
    let flint = "<bsdf type=\"dielectric\"><string name=\"dispersion\" value=\"sf11\"/></bsdf>";
    let shared =
        |name, share| reuse::shared(name, &with_links(&path(6), "guided"), share, &(globe() + &sheet));
    vec![
        relation("glass_and_metal", 0.0, &(block(&clear()) + &ball(&metal()) + &sheet)),
        relation("glass_and_metal_and_light_paths", 1.0, &(block(&metal()) + &ball(&clear()) + &sheet)),
        relation("bulb", 0.0, &(globe() + &sheet)),
        relation("matte_within_glass", 1.0, &within()),
        relation("vase", 0.0, &(vase(&clear()) + &dull)).samples(1024),
        relation("plastic_and_a_veil", 0.0, &(globe() + &veil() + &sphere([0.9, -0.3, 0.4], 0.4, &plastic))),
        relation("glass_that_shines", 0.0, &(shining + &ball(&metal()))),
        with_integrator(relation("four_samples", 0.0, &globe()), four).at_length(),
        relation("slab", 0.0, &slab),
        up_to(3, "one_edge_too_far", 0.0, &ball(&clear())),
        up_to(4, "no_edge_too_far", 0.0, &ball(&clear())),
        relation("dispersion", 0.0, &(block(flint) + &ball(&metal()))).in_spectra().longer(2),
        shared("path_re_use", 1.0).at_length(),
        shared("path_re_use_at_all_vertices", 0.0).at_length(),
    ]
}
