//! Relations of light paths: they change the noise only, whatever lens, film, glass and surface they pass.

use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;

/// A path integrator with `share` light paths per camera path, and paths of at most `longest` edges.
pub(super) fn with_light_paths(share: f64, longest: i64) -> String {
    path(longest).replace("</integrator>", &(float("light_paths", share) + "</integrator>"))
}

/// The integrator with emitters sampled through glass and by mirrors at the vertices that `at` names.
pub(super) fn with_links(integrator: &str, at: &str) -> String {
    integrator.replace("</integrator>", &format!("<string name=\"links\" value=\"{at}\"/></integrator>"))
}

/// The integrator that finds all light from the camera, and light through glass by scattering only.
pub(super) fn plain(longest: i64) -> String {
    with_links(&with_light_paths(0.0, longest), "never")
}

/// The relation that `integrator` has the expectation of [`plain`].
pub(super) fn as_plain(
    name: &str,
    longest: i64,
    integrator: String,
    (camera, world): (&str, &str),
) -> Relation {
    let side = |integrator: String| vec![Term::new(scene(&[&integrator, camera, world]))];
    Relation::expectation(name, side(plain(longest)), side(integrator)).samples(4096)
}

/// A matte floor and wall under a lamp, with further objects.
pub(super) fn room(things: &str) -> String {
    let objects = objects(&[]);
    objects[..2].concat() + &lamp(8.0) + things
}

pub(super) fn glass(more: &str) -> String {
    bsdf("dielectric", &(float("int_ior", 1.5) + more))
}

/// A ball above the floor.
pub(super) fn ball(wears: &str) -> String {
    sphere([-0.5, 0.0, 0.7], 0.6, wears)
}

pub(super) fn block(wears: &str) -> String {
    shape("cube", &[scale([0.4, 0.4, 0.5]), rotate('z', 25.0), translate([0.8, 0.2, 0.55])], wears)
}

/// A mesh with shading normals, the shape of a vase.
pub(super) fn vase(wears: &str) -> String {
    let steps = [scale([0.6; 3]), rotate('x', 90.0), translate([-0.6, 0.0, 0.1])];
    shape("obj", &steps, &format!("<string name=\"filename\" value=\"meshes/vase.obj\"/>{wears}"))
}

/// A sheet beside the objects, upright and turned towards them.
pub(super) fn sheet(wears: &str) -> String {
    shape("rectangle", &[scale([1.0; 3]), rotate('y', -60.0), translate([1.6, 0.3, 1.0])], wears)
}

/// A lamp in a ball of glass.
pub(super) fn globe() -> String {
    sphere([-0.5, 0.0, 1.0], 0.25, &area(4.0)) + &sphere([-0.5, 0.0, 1.0], 0.6, &glass(""))
}

/// A matte sphere in a ball of glass.
pub(super) fn within() -> String {
    sphere([-0.5, 0.0, 0.8], 0.7, &glass("")) + &sphere([-0.5, 0.0, 0.8], 0.4, &diffuse(0.6))
}

/// A matte material that transmits half of the light unchanged.
pub(super) fn half_open(albedo: f64) -> String {
    format!("<bsdf type=\"mask\">{}{}</bsdf>", float("opacity", 0.5), diffuse(albedo))
}

/// A material with different sides that may transmit light. No light path scatters there, since its BSDF
/// depends on the side of the camera.
pub(super) fn two_sided(wears: &str) -> String {
    format!("<bsdf type=\"twosided\"><boolean name=\"allow_transmission\" value=\"true\"/>{wears}</bsdf>")
}

/// An upright sheet that faces the camera.
fn upright(y: f64, wears: &str) -> String {
    let steps = [scale([0.6, 0.6, 1.0]), rotate('x', 90.0), translate([0.3, y, 0.8])];
    shape("rectangle", &steps, wears)
}

/// A half-transparent sheet in front of the objects.
pub(super) fn veil() -> String {
    upright(-1.5, &half_open(0.4))
}

/// A plate that reflects light from above onto the wall, with shading normals that are all turned by 20°.
fn turned_plate(wears: &str) -> String {
    let steps = [scale([0.6, 0.6, 1.0]), rotate('x', -30.0), translate([-0.3, 0.0, 0.9])];
    shape("obj", &steps, &format!("<string name=\"filename\" value=\"meshes/turned_plate.obj\"/>{wears}"))
}

/// A wall that mirrors one lamp to where the camera looks and another to where light goes from there: of
/// the two, whoever chooses by what is mirrored must know which end asks.
pub(super) fn wall_before_two_lamps(wears: &str) -> String {
    let facing = |degrees: f64, size: f64, place| [scale([size; 3]), rotate('x', degrees), translate(place)];
    let floor = shape("rectangle", &[scale([2.0; 3])], &diffuse(0.8));
    let wall = shape("rectangle", &facing(90.0, 2.0, [0.0, 2.2, 2.0]), wears);
    let lamp = |z: f64| shape("rectangle", &facing(-90.0, 0.3, [0.0, -1.0, z]), &area(5.0));
    floor + &wall + &lamp(4.0) + &lamp(0.5)
}

/// The view down to the floor before that wall.
pub(super) fn down_upon_the_floor() -> String {
    let place = look_at([0.0, -6.0, 6.0], [0.0; 3], [0.0, 0.0, 1.0]);
    pinhole(&place, 30.0, &(film(SIZE, SIZE) + INDEPENDENT))
}

/// Number of edges of the longest path by default.
const LONGEST: i64 = 6;

fn relation(name: &str, camera: &str, world: &str) -> Relation {
    up_to(LONGEST, name, camera, world)
}

fn up_to(longest: i64, name: &str, camera: &str, world: &str) -> Relation {
    as_plain(name, longest, with_light_paths(1.0, longest), (camera, world))
}

/// The relation with an option appended to the integrator element of both sides.
pub(super) fn with_integrator(relation: Relation, option: &str) -> Relation {
    replaced(relation, "</integrator>", option)
}

/// The relation with a piece of the scenes of both sides replaced.
fn replaced(relation: Relation, piece: &str, by: &str) -> Relation {
    let with = |terms: Vec<Term>| {
        let with = |term: Term| Term { scene: term.scene.replace(piece, by), ..term };
        terms.into_iter().map(with).collect()
    };
    Relation { left: with(relation.left), right: with(relation.right), ..relation }
}

pub fn relations() -> Vec<Relation> {
    let place = || look_at(EYE, [0.0, 0.0, 0.6], [0.0, 0.0, 1.0]);
    let filtered = |filter: &str, more: &str| {
        let film = film(SIZE, SIZE)
            .replace("<rfilter type=\"box\"/>", filter)
            .replace("</film>", &format!("{more}</film>"));
        pinhole(&place(), 42.0, &(film + INDEPENDENT))
    };
    let camera_of = |kind: &str, more: &str, steps: &[String]| {
        format!("<sensor type=\"{kind}\">{more}{}{}{INDEPENDENT}</sensor>", to_world(steps), film(SIZE, SIZE))
    };
    let lens = camera_of(
        "thinlens",
        &(float("fov", 42.0) + &float("aperture_radius", 0.2) + &float("focus_distance", 4.0)),
        &[place()],
    );
    let parallel = camera_of("orthographic", "", &[scale([1.6, 1.6, 1.0]), place()]);
    let crop = "<integer name=\"crop_offset_x\" value=\"3\"/><integer name=\"crop_offset_y\" value=\"9\"/>\
                <integer name=\"crop_width\" value=\"16\"/><integer name=\"crop_height\" value=\"14\"/>";
    let mirror = || bsdf("conductor", "");
    let pane = shape(
        "rectangle",
        &[scale([1.2, 1.2, 1.0]), translate([0.0, 0.0, 1.8])],
        &bsdf("thindielectric", ""),
    );
    let bulb = sphere([-0.5, 0.0, 1.0], 0.3, &area(3.0)) + &sphere([-0.5, 0.0, 1.0], 0.6, &glass(""));
    let floor =
        |wears: &str| shape("rectangle", &[scale([3.0, 3.0, 1.0]), translate([0.0, 0.0, 0.02])], wears);
    let rough_floor =
        floor(&bsdf("roughplastic", &(float("alpha", 0.3) + &grey("diffuse_reflectance", 0.5))));
    let metal_floor = floor(&rough_metal());
    let relief = |wears: &str| {
        let image = "<string name=\"filename\" value=\"textures/normals.png\"/>\
                     <boolean name=\"raw\" value=\"true\"/>";
        bsdf("normalmap", &format!("<texture type=\"bitmap\" name=\"normalmap\">{image}</texture>{wears}"))
    };
    let as_it_comes = |relief: &str| {
        let off = |name: &str| format!("<boolean name=\"{name}\" value=\"false\"/>");
        let both = off("flip_invalid_normals") + &off("use_shadowing_function");
        relief.replace("<bsdf type=\"normalmap\">", &format!("<bsdf type=\"normalmap\">{both}"))
    };
    let blend =
        format!("<bsdf type=\"blendbsdf\">{}{}{}</bsdf>", float("weight", 0.5), diffuse(0.5), mirror());
    let second =
        shape("rectangle", &[scale([0.3; 3]), rotate('y', 90.0), translate([-2.0, -0.5, 1.0])], &area(20.0));
    let two_sided_veil = upright(-0.9, &two_sided(&(half_open(0.9) + &half_open(0.1))));
    let shining_floor = floor(&(diffuse(0.7) + &area(0.1)));
    let polished = bsdf("roughconductor", &float("alpha", 0.1));
    let frosted = bsdf("roughdielectric", &(float("alpha", 0.15) + &float("int_ior", 1.5)));
    let facets = float("spec_trans", 0.8) + &float("roughness", 0.3) + &float("anisotropic", 0.5);
    let sheet = bsdf("principledthin", &(facets + &float("diff_trans", 0.7)));
    // The lamp faces the camera and covers all of the view.
    let plate = {
        let steps = [scale([0.4; 3]), rotate('x', 90.0), translate([0.18, -4.1, 1.5])];
        shape("rectangle", &steps, &area(1.0))
    };
    let hanging = sphere([1.0, -0.5, 1.6], 0.2, &area(12.0));
    let four_emitter_samples = |relation: Relation| {
        let option = "<integer name=\"emitter_samples\" value=\"4\"/></integrator>";
        with_integrator(relation, option)
    };
    let roulette = |relation: Relation| {
        let from = |depth: u32| format!("<integer name=\"rr_depth\" value=\"{depth}\"/>");
        replaced(relation, &from(LONGEST as u32 + 1), &from(1))
    };
    let few_light_paths = |name, wall: String, sky: &str| {
        let world = wall_before_two_lamps(&wall) + sky;
        as_plain(name, 3, with_light_paths(0.25, 3), (&down_upon_the_floor(), &world))
    };
    let brushed = || bsdf("roughconductor", &float("alpha", 0.2));
    let varnished = bsdf("principled", &(float("metallic", 0.8) + &float("roughness", 0.4)));
    let veiled_metal = bsdf("blendbsdf", &(float("weight", 0.3) + &brushed() + &diffuse(0.5)));
    let dim_mirror = bsdf("conductor", &grey("specular_reflectance", 0.4));
    let hidden = |relation: Relation| {
        with_integrator(relation, "<boolean name=\"hide_emitters\" value=\"true\"/></integrator>")
    };
    let (view, tent) = (camera(), "<rfilter type=\"tent\"/>");
    vec![
        relation("glass_ball", &view, &room(&ball(&glass("")))),
        relation("mirror_ball", &view, &room(&ball(&mirror()))),
        roulette(relation("roulette", &view, &room(&ball(&dim_mirror)))),
        relation("thin_lens", &lens, &room(&ball(&glass("")))).samples(2048),
        relation("parallel_view", &parallel, &room(&ball(&glass("")))).samples(2048),
        relation("gaussian_film", &filtered("<rfilter type=\"gaussian\"/>", ""), &room(&ball(&mirror()))),
        relation(
            "ringing_film_cropped",
            &filtered("<rfilter type=\"lanczos\"/>", crop),
            &room(&ball(&mirror())),
        )
        .longer(4),
        relation(
            "film_with_border",
            &filtered(tent, "<boolean name=\"sample_border\" value=\"true\"/>"),
            &room(&ball(&mirror())),
        )
        .longer(2),
        relation("pane", &view, &room(&pane)),
        relation("polished_metal", &view, &room(&ball(&polished))).longer(2),
        relation("polished_metal_by_two_lamps", &view, &room(&(ball(&polished) + &second + &hanging)))
            .at_length(),
        few_light_paths("brushed_metal_before_two_lamps", brushed(), ""),
        few_light_paths("principled_metal_before_two_lamps", varnished, "").at_length(),
        few_light_paths("veiled_metal_before_two_lamps_and_sky", veiled_metal, &constant(0.1)).at_length(),
        four_emitter_samples(relation("polished_metal_by_four_samples", &view, &room(&ball(&polished))))
            .at_length(),
        relation("frosted_glass", &view, &room(&block(&frosted))).samples(1024),
        relation("thin_sheets", &view, &room(&block(&sheet))).samples(1024),
        relation("bulb_in_a_globe", &view, &room(&bulb)),
        relation("block_of_glass", &view, &room(&block(&glass("")))),
        relation("tinted_glass", &view, &room(&block(&glass(&grey("specular_transmittance", 0.6))))),
        // Through glass the floor is three edges from the lamp, and the camera a fourth.
        up_to(3, "glass_ball_one_edge_too_far", &view, &room(&ball(&glass("")))),
        relation("upon_rough_plastic", &view, &room(&(ball(&mirror()) + &rough_floor))).at_length(),
        relation("upon_rough_metal", &view, &room(&(ball(&mirror()) + &metal_floor))).at_length(),
        relation("relief_of_a_mirror", &view, &room(&block(&relief(&mirror())))),
        relation("relief_of_glass", &view, &room(&block(&relief(&glass(""))))),
        relation("relief_of_a_mirror_as_it_comes", &view, &room(&block(&as_it_comes(&relief(&mirror()))))),
        relation("relief_of_glass_as_it_comes", &view, &room(&block(&as_it_comes(&relief(&glass("")))))),
        relation("vase_of_glass", &view, &room(&vase(&glass("")))).at_length(),
        relation("vase_of_polished_metal", &view, &room(&vase(&polished))).at_length(),
        relation("turned_plate", &view, &room(&turned_plate(&polished))),
        relation("relief_of_polished_metal", &view, &room(&block(&relief(&polished)))).at_length(),
        relation("half_a_mirror", &view, &room(&(ball(&blend) + &block(&mirror())))),
        relation("two_lamps", &view, &room(&(ball(&mirror()) + &second))).samples(8192).at_length(),
        relation("behind_a_veil", &view, &room(&(ball(&mirror()) + &veil()))),
        hidden(relation("behind_a_hidden_lamp", &view, &room(&(ball(&glass("")) + &plate)))),
        // A lamp that also reflects, and through which the camera looks.
        hidden(relation("upon_a_hidden_lamp", &view, &room(&(ball(&mirror()) + &shining_floor))))
            .samples(8192),
        relation("two_sided_glass", &view, &room(&block(&two_sided(&glass(""))))),
        relation("two_sided_frosted_glass", &view, &room(&ball(&two_sided(&frosted)))).samples(1024),
        relation("two_sided_veil", &view, &room(&(ball(&mirror()) + &two_sided_veil))),
        relation("in_spectra", &view, &room(&ball(&glass("")))).in_spectra().at_length(),
        relation(
            "dispersion",
            &view,
            &room(&block("<bsdf type=\"dielectric\"><string name=\"dispersion\" value=\"sf11\"/></bsdf>")),
        )
        .in_spectra(),
    ]
}
