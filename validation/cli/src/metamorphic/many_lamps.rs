//! The light of many emitters is the sum of the light of each alone: emitters are selected with probabilities
//! that depend on the receiver, and a single emitter needs no selection.

use super::caustics::{ball, glass, with_light_paths, with_links};
use super::reuse::one_of;
use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;
use validation::image::Image;

/// Emitters with a surface, outside of the view. Those that are not lit are black.
fn lamps(lit: impl Fn(usize) -> bool) -> String {
    let kinds: [(&str, Vec<String>, f64); 5] = [
        ("rectangle", lamp_steps(), 4.0),
        ("sphere", vec![scale([0.1; 3]), translate([-1.2, -0.8, 2.4])], 30.0),
        ("obj", vec![scale([0.1, 0.2, 0.1]), rotate('z', 30.0), translate([0.9, -0.9, 2.4])], 20.0),
        ("cylinder", vec![scale([0.03, 0.03, 0.8]), rotate('y', 90.0), translate([-0.4, 0.6, 2.6])], 20.0),
        // At the height of the objects, with half of the floor behind it.
        ("disk", vec![scale([0.3; 3]), rotate('y', -80.0), translate([2.4, 0.2, 0.8])], 20.0),
    ];
    let lamp = |(i, (kind, steps, radiance)): (usize, (&str, Vec<String>, f64))| {
        let mesh = if kind == "obj" { CUBE_OF_TRIANGLES } else { "" };
        let shines = if lit(i) { area(radiance) } else { String::new() };
        shape(kind, &steps, &(mesh.to_owned() + &diffuse(0.0) + &shines))
    };
    kinds.into_iter().enumerate().map(lamp).collect()
}

/// Emitters without a surface.
fn lights() -> [String; 5] {
    let spot = |steps: &[String]| {
        emitter("spot", &(to_world(steps) + &float("cutoff_angle", 30.0) + &grey("intensity", 6.0)))
    };
    let aimed = look_at([1.8, -1.5, 2.2], [0.4, 0.0, 0.3], [0.0, 0.0, 1.0]);
    let sheared = "<matrix value=\"1 0.6 0 0  0 1 0 0  0 0 1 0  0 0 0 1\"/>".to_owned();
    let down = [sheared, rotate('x', 180.0), translate([-1.0, 0.0, 2.0])];
    [
        point_light(-1.0, 2.0),
        spot(&[aimed]),
        spot(&down),
        constant(0.1),
        emitter(
            "directional",
            "<vector name=\"direction\" x=\"0.5\" y=\"1\" z=\"-1\"/><rgb name=\"irradiance\" value=\"0.5\"/>",
        ),
    ]
}

/// Things that mirror one lamp here and another there: of each model that has such a lobe, and of some that
/// pass on another's.
fn glossy_things() -> String {
    let metal = bsdf("roughconductor", &float("alpha", 0.1));
    let varnished = bsdf("roughplastic", &float("alpha", 0.1));
    let brushed = bsdf("principled", &(float("metallic", 0.8) + &float("roughness", 0.3)));
    let veiled = bsdf("mask", &(float("opacity", 0.7) + &metal));
    let both = bsdf("twosided", &(metal.clone() + &varnished));
    let mixed = bsdf("blendbsdf", &(float("weight", 0.3) + &both + &diffuse(0.5)));
    let things = [metal, varnished, brushed, veiled, mixed];
    let ball = |(i, wears): (usize, String)| sphere([-1.2 + 0.5 * i as f64, -0.9, 0.25], 0.22, &wears);
    things.into_iter().enumerate().map(ball).collect()
}

const LAMPS: usize = 5;

/// The relation that the integrator's image of a room with all lamps and these lights is the sum of the
/// images with one of them each.
fn together(
    name: &str,
    integrator: &str,
    (things, lights): (&str, &[String]),
    view: Option<fn(&Image) -> Image>,
) -> Relation {
    let room = |lit: &dyn Fn(usize) -> bool, lights: &str| {
        let text = scene(&[integrator, &camera(), &objects(&[]).concat(), things, &lamps(lit), lights]);
        Term { view, ..Term::new(text) }
    };
    let shapes = (0..LAMPS).map(|one| room(&move |i| i == one, ""));
    let alone = shapes.chain(lights.iter().map(|light| room(&|_| false, light))).collect();
    Relation::expectation(name, alone, vec![room(&|_| true, &lights.concat())]).samples(512)
}

/// The relation for all kinds of emitters.
fn all_kinds(name: &str, integrator: &str) -> Relation {
    together(name, integrator, ("", &lights()), None)
}

pub fn relations() -> Vec<Relation> {
    let direct = "<integrator type=\"direct\"/>";
    let by_emitters = "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"2\"/>\
                       <integer name=\"bsdf_samples\" value=\"0\"/></integrator>";
    let things =
        ball(&glass("")) + &sphere([1.3, -0.2, 1.0], 0.3, &bsdf("roughconductor", &float("alpha", 0.15)));
    let found_by_all = with_links(&with_light_paths(1.0, 5), "everywhere");
    let shared = path(4).replace(
        "</integrator>",
        "<integer name=\"reuse\" value=\"16\"/><integer name=\"shared_light_paths\" value=\"2\"/></integrator>",
    );
    vec![
        all_kinds("path", &path(4)).longer(2),
        all_kinds("direct", direct).samples(1024).at_length(),
        all_kinds("by_emitters_alone", by_emitters).longer(2).at_length(),
        together("light_paths_and_links", &found_by_all, (&things, &[]), None)
            .within(0.02)
            .samples(1024)
            .at_length(),
        together("glossy", &path(4), (&glossy_things(), &lights()), None).longer(2),
        together("glossy_by_volpath", &path(4).replace("path", "volpath"), (&glossy_things(), &[]), None)
            .samples(4096)
            .at_length(),
        together("shared_paths", &shared, ("", &[]), Some(one_of::<4>)).within(0.05).samples(1024),
    ]
}
