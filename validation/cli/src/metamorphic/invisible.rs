//! Objects that must be invisible, and adapters that must have no effect.

use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;

pub fn relations() -> Vec<Relation> {
    // Path lengths are not limited, because invisible surfaces lengthen paths.
    let plain = || vec![Term::new(endless(""))];
    let besides =
        |name: &str, more: &str| Relation::expectation(name, plain(), vec![Term::new(endless(more))]);
    let ball = |wears: &str| sphere([0.0, -1.5, 1.0], 0.6, wears);
    let pane = |wears: &str| shape("rectangle", &[rotate('x', 90.0), translate([0.0, -2.0, 1.0])], wears);
    let one = float("int_ior", 1.0) + &float("ext_ior", 1.0);
    let (matte, metal) = (diffuse(0.7), rough_metal());
    let dressed = |wears: &str| vec![Term::new(with("").replace(&matte, wears))];
    let same =
        |name: &str, wears: &str| Relation::expectation(name, vec![Term::new(with(""))], dressed(wears));
    let blend = |weight: f64, first: &str, second: &str| {
        bsdf("blendbsdf", &(float("weight", weight) + first + second))
    };
    let mask = |opacity: f64, inside: &str| bsdf("mask", &(float("opacity", opacity) + inside));
    let twosided = bsdf("twosided", &matte);
    let null = bsdf("null", "");
    vec![
        besides("null_ball", &ball(&null)),
        besides("null_pane", &pane(&null)),
        besides("mask_of_opacity_0", &ball(&mask(0.0, &metal))),
        besides("glass_of_index_1", &pane(&bsdf("dielectric", &one))),
        besides("thin_glass_of_index_1", &ball(&bsdf("thindielectric", &one))),
        same("mask_of_opacity_1", &mask(1.0, &matte)),
        same("blend_of_weight_0", &blend(0.0, &matte, &metal)),
        same("blend_of_weight_1", &blend(1.0, &metal, &matte)),
        same("blend_with_itself", &blend(0.4, &matte, &matte)),
        same("twosided", &twosided),
        same("twosided_twice", &bsdf("twosided", &(matte.clone() + &matte))),
        large_veil(&null),
        shell_beside_a_lamp(&null),
        same("blend_of_greys", &blend(0.25, &diffuse(0.6), &diffuse(1.0))),
        same(
            "texture_of_one_colour",
            &matte.replace("<rgb name=\"reflectance\" value=\"0.7\"/>", ONE_COLOUR),
        ),
    ]
}

/// A floor under a lamp, and between them a surface that nothing is seen of, so large that its points are rounded
/// by more than a shadow ray ends before the lamp.
fn large_veil(wears: &str) -> Relation {
    let turn = || rotate('x', 33.7) + &rotate('z', 20.0);
    // Its middle is as far away as it is large: about it points would be computed from small numbers.
    let level = |half: f64, height: f64, more: &str| {
        let aside = [rotate('x', -90.0), translate([0.37, 0.0, 0.21]), scale([half; 3])];
        let steps = [aside.concat(), translate([0.0, height, 0.0]), turn()];
        shape("rectangle", &steps, more)
    };
    let steps = [scale([0.3, 0.3, 1.0]), rotate('x', 90.0), translate([0.0, 1.2, 0.0]), turn()];
    let lamp = shape("rectangle", &steps, &area(5.0));
    let place = look_at([1.2, 0.3, 2.0], [0.0; 3], [0.0, 1.0, 0.0]) + &turn();
    let camera = pinhole(&place, 60.0, &(film(16, 16) + INDEPENDENT));
    let volpath = "<integrator type=\"volpath\"><integer name=\"max_depth\" value=\"3\"/></integrator>";
    let room = camera + volpath + &level(2.0, 0.0, "") + &lamp;
    let veiled = room.clone() + &level(1e5, 0.8, wears);
    let side = |room: &str| vec![Term::new(scene(&[room]))];
    Relation::expectation("large_veil", side(&room), side(&veiled)).longer(32)
}

/// A floor under a lamp and a sky, and a shell of which nothing is seen, next to the lamp: where a path passes it, the lamp
/// is much nearer than from where the path was scattered.
fn shell_beside_a_lamp(wears: &str) -> Relation {
    let floor = shape("rectangle", &[scale([2.0; 3]), rotate('x', -90.0)], &diffuse(0.6));
    let lamp =
        shape("rectangle", &[scale([0.1; 3]), rotate('x', 90.0), translate([0.0, 1.2, 0.0])], &area(20.0));
    let place = look_at([1.2, 0.3, 2.0], [0.0; 3], [0.0, 1.0, 0.0]);
    let camera = pinhole(&place, 60.0, &(film(16, 16) + INDEPENDENT));
    let volpath = "<integrator type=\"volpath\"><integer name=\"max_depth\" value=\"3\"/></integrator>";
    let room = camera + volpath + &floor + &lamp + &constant(0.5);
    let veiled = room.clone() + &sphere([0.0; 3], 1.15, wears);
    let side = |room: &str| vec![Term::new(scene(&[room]))];
    Relation::expectation("shell_beside_a_lamp", side(&room), side(&veiled)).longer(16)
}

const ONE_COLOUR: &str = "<texture type=\"checkerboard\" name=\"reflectance\"><rgb name=\"color0\" value=\"0.7\"/>\
     <rgb name=\"color1\" value=\"0.7\"/></texture>";

/// Light that meets an invisible surface on its way to a lamp is found by chance only, so the lamp is a sky.
fn endless(more: &str) -> String {
    with_light(&(constant(1.0) + more)).replace(&path(4), &path(-1))
}
