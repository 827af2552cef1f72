//! Sensors that measure one number: radiance along rays, and irradiance as form factors.

use super::ClosedForm;
use crate::stage::*;
use std::f64::consts::PI;

pub fn cases() -> Vec<ClosedForm> {
    [radiance(), form_factors(), lit_by_points(), surrounded()].concat()
}

fn meter(kind: &str, parameters: &str) -> String {
    format!("<sensor type=\"{kind}\">{parameters}{}</sensor>", film(1, 1))
}

fn radiance() -> Vec<ClosedForm> {
    let along = |[x, y, z]: Point| format!("<vector name=\"direction\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
    let oblique = along([0.5, -0.3, -1.0]);
    let ball = sphere([0.4, -0.2, 1.0], 0.3, &area(1.0));
    let outline = scene(&[&path(1), &meter("distant", &oblique), &ball]);
    // Of the rectangle below it the ball hides an ellipse, which lies within.
    let target = format!(
        "<shape type=\"rectangle\" name=\"target\">{}</shape>",
        to_world(&[scale([0.6, 0.5, 1.0]), rotate('z', 30.0), translate([0.9, -0.5, 0.0])])
    );
    let below = scene(&[&path(1), &meter("distant", &format!("{oblique}{target}")), &ball]);
    let cos = 1.0 / (0.25f64 + 0.09 + 1.0).sqrt();
    let floor = shape("rectangle", &[scale([50.0, 50.0, 1.0])], &diffuse(0.8));
    let lamp = emitter(
        "point",
        &format!("<point name=\"position\" x=\"0\" y=\"0\" z=\"2\"/>{}", grey("intensity", 10.0)),
    );
    let origin = "<point name=\"origin\" x=\"1\" y=\"0\" z=\"1\"/>";
    let one = scene(&[
        &path(2),
        &meter("radiancemeter", &format!("{origin}{}", along([0.5, 0.0, -1.0]))),
        &floor,
        &lamp,
    ]);
    let at = "<point name=\"target\" x=\"1.5\" y=\"0\" z=\"0\"/>";
    let same = scene(&[&path(2), &meter("distant", &format!("{oblique}{at}")), &floor, &lamp]);
    // At (1.5, 0, 0): d² = 2.5², cos = 2/2.5.
    let lit = 0.8 / PI * 10.0 * (2.0 / 2.5) / (2.5 * 2.5);
    vec![
        ClosedForm::new(
            "distant_outline",
            "πr²/(πR²) with R = √3 r: a ball in the ball around its box",
            outline,
            1.0 / 3.0,
        )
        .samples(1 << 16),
        ClosedForm::new(
            "distant_rectangle",
            "πr²/(A cos θ): the shadow of a ball on a rectangle of 1.2 m²",
            below,
            0.09 * PI / (1.2 * cos),
        )
        .samples(1 << 16),
        ClosedForm::new("radiancemeter_lambert", "ρ/π · I cos θ/d²", one, lit),
        ClosedForm::new("distant_point", "ρ/π · I cos θ/d², from any side", same, lit),
    ]
}

/// A luminous surface seen by one with a meter.
fn form_factors() -> Vec<ClosedForm> {
    const GAP: f64 = 0.25;
    const WIDTH: f64 = 0.25;
    let meter = meter("irradiancemeter", "");
    let square =
        |steps: &[String], wears: &str| shape("rectangle", &[&[scale([0.5; 3])], steps].concat(), wears);
    let below = square(&[], &meter);
    let above = square(&[rotate('x', 180.0), translate([0.0, 0.0, GAP])], &area(1.0));
    let strip = square(&[scale([1.0, WIDTH, 1.0])], &meter);
    // Its front faces +y; both have the edge at y = −WIDTH/2.
    let beside = square(&[rotate('x', -90.0), translate([0.0, -0.5 * WIDTH, 0.5])], &area(1.0));
    let (radius, height) = (2.7, 0.9);
    let disk =
        shape("disk", &[scale([radius; 3]), rotate('x', 180.0), translate([0.0, 0.0, height])], &area(1.0));
    let ball = sphere([0.0; 3], 0.4, &meter);
    let plate = shape("disk", &[scale([0.5; 3])], &meter);
    let spot = shape("disk", &[scale([0.02; 3]), rotate('x', 180.0), translate([0.0, 0.0, 1.0])], &area(1.0));
    let lamps = [
        (
            "opposite_squares",
            "πL F₁₂ of two parallel squares (Howell's catalogue, C-11)",
            [&below, &above],
            of_opposite_squares(1.0 / GAP),
        ),
        (
            "at_an_edge",
            "πL F₁₂ of two rectangles at a right angle with a common edge (Howell's catalogue, C-14)",
            [&strip, &beside],
            at_an_edge(WIDTH, 1.0),
        ),
        (
            "ball_below_a_disk",
            "πL ½(1 − h/√(h² + r²)): the share of all directions",
            [&ball, &disk],
            0.5 * (1.0 - height / libm::hypot(radius, height)),
        ),
        (
            "a_small_lamp",
            "πL F₁₂ of two disks on one axis (Howell's catalogue, C-41)",
            [&plate, &spot],
            of_disks(0.5, 0.02),
        ),
    ];
    let form = |(name, source, shapes, factor): (&'static str, &'static str, [&String; 2], f64)| {
        let scene = scene(&[&path(1), shapes[0], shapes[1]]);
        ClosedForm::new(name, source, scene, PI * factor).samples(1 << 19).margin(0.0025)
    };
    lamps.into_iter().map(form).collect()
}

/// Of squares of side x at a distance of 1.
fn of_opposite_squares(x: f64) -> f64 {
    let x2 = x * x;
    let root = (1.0 + x2).sqrt();
    let logarithm = libm::log((1.0 + x2) / (1.0 + 2.0 * x2).sqrt());
    2.0 / (PI * x2) * (logarithm + 2.0 * x * (root * libm::atan(x / root) - libm::atan(x)))
}

/// From a disk of radius r to one of radius s on the same axis, at a distance of 1.
fn of_disks(r: f64, s: f64) -> f64 {
    let x = 1.0 + (1.0 + s * s) / (r * r);
    let ratio = 2.0 * s / r;
    0.5 * ratio * ratio / (x + (x * x - ratio * ratio).sqrt())
}

/// From a rectangle of width w to one of height h at a right angle, at their common edge of length 1.
fn at_an_edge(w: f64, h: f64) -> f64 {
    let (w2, h2) = (w * w, h * h);
    let (all, diagonal) = (1.0 + w2 + h2, (w2 + h2).sqrt());
    let angles = w * libm::atan(1.0 / w) + h * libm::atan(1.0 / h) - diagonal * libm::atan(1.0 / diagonal);
    let along = |a: f64| a * libm::log(a * all / ((1.0 + a) * (w2 + h2)));
    let logarithms = libm::log((1.0 + w2) * (1.0 + h2) / all) + along(w2) + along(h2);
    (angles + 0.25 * logarithms) / (PI * w)
}

/// Lamps that no ray meets.
fn lit_by_points() -> Vec<ClosedForm> {
    const HEIGHT: f64 = 0.7;
    let meter = meter("irradiancemeter", "");
    let square = shape("rectangle", &[scale([0.5; 3])], &meter);
    let place = format!("<point name=\"position\" x=\"0\" y=\"0\" z=\"{HEIGHT}\"/>");
    let lamp = emitter("point", &format!("{place}{}", grey("intensity", 2.0)));
    // Of a square of side 1 about the foot of the lamp.
    let solid_angle = 4.0 * libm::atan(0.25 / (HEIGHT * (0.5 + HEIGHT * HEIGHT).sqrt()));
    let direct = "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"3\"/></integrator>";
    let by = |name: &'static str, integrator: &str| {
        ClosedForm::new(
            name,
            "I Ω/A: the light of a point within the solid angle of a square",
            scene(&[integrator, &square, &lamp]),
            2.0 * solid_angle,
        )
        .samples(1 << 12)
    };
    let sun = emitter(
        "directional",
        &format!("<vector name=\"direction\" x=\"0.5\" y=\"-0.3\" z=\"-1\"/>{}", grey("irradiance", 3.0)),
    );
    let ball = sphere([0.0; 3], 0.4, &format!("{}{meter}", diffuse(0.3)));
    vec![
        by("below_a_point", &path(1)),
        by("below_a_point_direct", direct),
        ClosedForm::new(
            "ball_in_the_sun",
            "E/4: a ball's shadow over its surface",
            scene(&[&path(1), &ball, &sun]),
            0.75,
        )
        .samples(1 << 14),
        ClosedForm::new(
            "point_through_fog",
            "I exp(−σd)/d²",
            scene(&[
                "<integrator type=\"volpath\"/>",
                &small_disk_in_fog(),
                &emitter("point", &format!("{}{}", place.replace("0.7", "2"), grey("intensity", 2.0))),
            ]),
            0.5 * libm::exp(-1.4),
        ),
    ]
}

/// In air with an extinction of 0.7 m⁻¹.
fn small_disk_in_fog() -> String {
    let black = "<rgb name=\"albedo\" value=\"0\"/>";
    let fog =
        format!("<medium name=\"exterior\" type=\"homogeneous\">{}{black}</medium>", grey("sigma_t", 0.7));
    shape("disk", &[scale([1e-3; 3])], &format!("{}{fog}{}", diffuse(0.0), meter("irradiancemeter", "")))
}

/// Meters with light from everywhere.
fn surrounded() -> Vec<ClosedForm> {
    let meter = meter("irradiancemeter", "");
    let inside = format!(
        "<shape type=\"sphere\"><boolean name=\"flip_normals\" value=\"true\"/>{}{}{meter}</shape>",
        diffuse(0.5),
        area(1.0)
    );
    let cube =
        shape("cube", &[scale([0.3, 0.5, 0.2]), rotate('y', 20.0)], &format!("{}{meter}", diffuse(0.0)));
    let wall = format!(
        "<shape type=\"sphere\"><float name=\"radius\" value=\"2\"/>{}{}</shape>",
        diffuse(0.0),
        emitter("area", &grey("radiance", 1.0)),
    )
    .replacen("/>", "/><boolean name=\"flip_normals\" value=\"true\"/>", 1);
    vec![
        ClosedForm::new(
            "in_an_integrating_sphere",
            "πL/(1 − ρ): a wall that shines and reflects, measured by itself",
            scene(&[&path(64), &inside]),
            2.0 * PI,
        )
        .samples(1 << 14),
        ClosedForm::new(
            "under_a_white_sky",
            "πL, whatever the surface",
            scene(&[&path(1), &cube, &constant(1.0)]),
            PI,
        ),
        ClosedForm::new(
            "in_fog",
            "πL exp(−σr) in the midst of a ball: rays begin in what the surface has around it",
            scene(&["<integrator type=\"volpath\"/>", &small_disk_in_fog(), &wall]),
            PI * libm::exp(-1.4),
        ),
    ]
}
