//! Very bright, very dim and very small lights, and light that is hardly attenuated.

use super::Case;
use crate::closed_forms::ClosedForm;
use crate::closed_forms::irradiance::{floor_under, shown};
use crate::metamorphic::still_life::{camera, lamp, objects};
use crate::stage::*;
use etalon::render::Settings;
use etalon::spectrum::ColorMode;
use std::f64::consts::PI;

const DISK: &str = "E = πLr²/(r² + h²) under the middle of a disk";

pub fn cases() -> Vec<Case> {
    let mut answers = vec![];
    for power in [-30, -12, 12, 30] {
        let radiance = libm::exp10(f64::from(power));
        let (lights, e) = disk(0.5, radiance);
        answers.push(
            ClosedForm::new(format!("radiance_10^{power}"), DISK, floor_under(&lights), shown(e))
                .samples(1 << 13),
        );
    }
    for radius in [1e-6, 1e-12] {
        let (lights, e) = disk(radius, 1.0 / (radius * radius));
        answers.push(ClosedForm::new(format!("lamp_of_{radius:e}"), DISK, floor_under(&lights), shown(e)));
    }
    for (name, radius, radiance) in [("ratio_1e12_alike", 5e-7, 1e12), ("ratio_1e12_unlike", 0.4, 1e12)] {
        let ((small, e1), (large, e2)) = (disk(radius, radiance), disk(0.6, 1.0));
        let (lights, e) = (small + &large.replace("z=\"1\"", "z=\"2\""), e1 + e2 * 1.36 / 4.36);
        answers.push(
            ClosedForm::new(name, "irradiances add up", floor_under(&lights), shown(e)).samples(1 << 15),
        );
    }
    let (sun, sky) = (1e9, 1.0);
    let sine = 5e-5;
    let ball = sphere([0.0, 0.6e6, 0.8e6], 1e6 * sine, &area(sun)) + &constant(sky);
    let e = PI * (sun * sine * sine * 0.8 + sky);
    answers.push(
        ClosedForm::new(
            "sun_of_1e-4_rad",
            "E = π(L sin²σ cos θ + 1) of a sun in a sky of 1",
            floor_under(&ball),
            shown(e),
        )
        .samples(1 << 15),
    );
    answers.push(sun_in_a_map());
    answers.extend(closed_rooms());
    let mut cases: Vec<Case> = answers.into_iter().map(Case::answer).collect();
    cases.push(Case::at_most(
        "black",
        "a scene whose lamp is out is black: the largest value",
        0.0,
        Box::new(|_| black()),
    ));
    cases
}

/// A disk at height 1, and its irradiance at the origin.
fn disk(radius: f64, radiance: f64) -> (String, f64) {
    let steps = [scale([radius; 3]), rotate('x', 180.0), translate([0.0, 0.0, 1.0])];
    let e = PI * radiance * radius * radius / (radius * radius + 1.0);
    (shape("disk", &steps, &area(radiance)), e)
}

/// A map of 31 417 rows, the first of which is white: a cone of 10⁻⁴ rad around the pole, fading to its edge,
/// at the zenith.
fn sun_in_a_map() -> ClosedForm {
    let (radiance, edge) = (1e9, PI / 31_416.0);
    let file = "<string name=\"filename\" value=\"textures/sun.png\"/>";
    let parameters = file.to_string() + &float("scale", radiance) + &to_world(&[rotate('x', 90.0)]);
    // The integral is ¼ − sin 2δ/8δ; these are the first terms of its series.
    let e = 2.0 * PI * radiance * edge * edge / 6.0 * (1.0 - edge * edge / 5.0);
    let source = "E = 2πL ∫₀^δ (1 − θ/δ) sin θ cos θ dθ of a map whose first row is L, δ = 10⁻⁴ rad";
    ClosedForm::new(
        "sun_of_1e-4_rad_in_a_map",
        source,
        floor_under(&emitter("envmap", &parameters)),
        shown(e),
    )
}

/// Closed rooms with albedos that f32 represents exactly: 1 − 10⁻⁶ would have an error of 1.3 % in 1 − ρ.
fn closed_rooms() -> Vec<ClosedForm> {
    let room = |loss: f64, depth: i64| {
        let inside = "<boolean name=\"flip_normals\" value=\"true\"/>";
        let wall = sphere([0.0; 3], 1.0, &(inside.to_string() + &area(loss) + &diffuse(1.0 - loss)));
        scene(&[&path(depth), &pointed([0.3, 0.2, -0.1], [0.5, -0.3, 0.7]), &wall])
    };
    let loss = libm::exp2(-20.0);
    let bounces = 10_000;
    let expected = -libm::expm1(f64::from(bounces) * libm::log1p(-loss));
    vec![
        ClosedForm::new(
            "room_1-2^-20_10000_edges",
            "L = Lₑ(1 − ρᵐ)/(1 − ρ) after m edges in a sphere that glows (geometric series)",
            room(loss, i64::from(bounces)),
            expected,
        )
        .margin(0.0025)
        .samples(16),
        ClosedForm::new(
            "room_1-2^-10_roulette",
            "L = Lₑ/(1 − ρ), with roulette: a thousand bounces a path",
            room(libm::exp2(-10.0), -1),
            1.0,
        )
        .margin(0.05)
        .samples(1500),
    ]
}

fn black() -> Result<f64, String> {
    let text = scene(&[&path(4), &camera(), &objects(&[]).concat(), &lamp(0.0)]);
    let scene = load(&text, ColorMode::Rgb)?;
    let settings = Settings { seed: 1, ..Settings::of(&scene, 0..16) };
    let image = measured(&expose(&scene, &settings)?);
    Ok(image.channels.iter().flat_map(|c| c.mean.iter()).map(|v| v.abs()).fold(0.0, f64::max))
}
