//! Different methods for the same image: integrators, samplers, colour modes.

use super::still_life::*;
use super::{Alike, Relation, Term};
use crate::stage::*;
use etalon::spectrum::ColorMode;

pub fn relations() -> Vec<Relation> {
    let plain = || vec![Term::new(with(""))];
    let by = |integrator: &str| vec![Term::new(with("").replace(&path(4), integrator))];
    let direct_integrator = |emitters: u32, bsdfs: u32| {
        let count = |name: &str, n: u32| format!("<integer name=\"{name}\" value=\"{n}\"/>");
        let counts = count("emitter_samples", emitters) + &count("bsdf_samples", bsdfs);
        format!("<integrator type=\"direct\">{counts}</integrator>")
    };
    let direct = |emitters: u32, bsdfs: u32| by(&direct_integrator(emitters, bsdfs));
    let short = || by(&path(2));
    // Lamps on which the areas of a texture's parts are not in proportion, or, on the cube, that share a
    // texture between faces.
    let checkered = |kind: &str| {
        let board = "<texture type=\"checkerboard\" name=\"radiance\"><rgb name=\"color0\" value=\"0.1, 0.4, 1\"/>\
             <rgb name=\"color1\" value=\"1, 0.4, 0.1\"/><transform name=\"to_uv\"><scale value=\"3\"/></transform></texture>";
        let lamp = shape(kind, &[scale([0.6; 3]), translate([0.3, 0.2, 2.0])], &emitter("area", board));
        let side = |emitters: u32, bsdfs: u32| {
            let integrator = direct_integrator(emitters, bsdfs);
            vec![Term::new(with_light(&lamp).replace(&path(4), &integrator))]
        };
        let name = format!("bsdf_samples_only_of_a_checkered_{kind}");
        let samples = if kind == "cylinder" { 3072 } else { 1536 };
        Relation::expectation(name, side(1, 0), side(0, 16)).samples(samples).within(0.02)
    };
    let roulette = |depth: u32| {
        let settings = "<integer name=\"max_depth\" value=\"4\"/>";
        by(&format!(
            "<integrator type=\"path\">{settings}<integer name=\"rr_depth\" value=\"{depth}\"/></integrator>"
        ))
    };
    let four =
        path(4).replace("</integrator>", "<integer name=\"emitter_samples\" value=\"4\"/></integrator>");
    let four_first = four.replace("emitter_samples", "first_emitter_samples");
    let first_four_by = |light: &str, name: &str| {
        let side = |integrator: &str| vec![Term::new(with_light(light).replace(&path(4), integrator))];
        Relation::expectation(name, side(&path(4)), side(&four_first))
    };
    let by_point_light =
        |integrator: &str| vec![Term::new(with_light(&point_light(0.5, 3.0)).replace(&path(4), integrator))];
    let sampler = |kind: &str| {
        let text = with("").replace(INDEPENDENT, &format!("<sampler type=\"{kind}\"/>"));
        vec![Term::new(text)]
    };
    let spectral = Term { mode: ColorMode::Spectral, ..Term::new(with("")) };
    vec![
        Relation::expectation("roulette_from_1", plain(), roulette(1)),
        Relation::expectation("roulette_from_3", plain(), roulette(3)),
        Relation::expectation("four_emitter_samples", plain(), by(&four)),
        Relation::expectation("four_first_emitter_samples", plain(), by(&four_first)),
        first_four_by(&constant(1.0), "four_first_samples_of_surroundings"),
        Relation::expectation(
            "four_samples_of_a_point_light",
            by_point_light(&path(4)),
            by_point_light(&four),
        ),
        Relation::expectation("direct_is_path_of_2_edges", short(), direct(1, 1)),
        Relation::expectation("emitter_samples_only", short(), direct(1, 0)),
        Relation::expectation("bsdf_samples_only", short(), direct(0, 16)).samples(2048),
        checkered("sphere"),
        checkered("cylinder"),
        checkered("cube"),
        Relation::expectation("direct_4_and_2", short(), direct(4, 2)),
        Relation::expectation("sobol", plain(), sampler("sobol")),
        Relation::expectation("stratified", plain(), sampler("stratified")),
        Relation {
            alike: Alike::Bits,
            ..Relation::expectation("stratified_is_sobol", sampler("stratified"), sampler("sobol"))
        },
        Relation::expectation("grey_is_grey_in_spectra", plain(), vec![spectral]),
    ]
}
