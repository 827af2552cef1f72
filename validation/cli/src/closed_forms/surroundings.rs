//! Uniform surroundings, and objects seen in them.

use super::ClosedForm;
use crate::stage::*;

pub fn cases() -> Vec<ClosedForm> {
    let camera = pointed([-1.5, -2.0, 1.5], [0.0; 3]);
    let floor = shape("rectangle", &[], &diffuse(0.5));
    let screen =
        shape("disk", &[scale([0.7; 3]), rotate('x', 180.0), translate([0.0, 0.0, 1.0])], &diffuse(0.0));
    let ball = |wears: &str| {
        let place = look_at([0.0, -4.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = pinhole(&place, BALL_FOV, &film(8, 8));
        scene(&[&path(-1), &camera, &sphere([0.0; 3], 1.0, wears), &constant(1.0)])
    };
    let furnace = "a convex body of albedo ρ in a furnace of radiance 1 has radiance ρ";
    vec![
        ClosedForm::new(
            "sky_over_a_plane",
            "E = πL",
            scene(&[&path(2), &camera, &floor, &constant(1.0)]),
            0.5,
        ),
        ClosedForm::new(
            "sky_behind_a_disk",
            "E = πL(1 − r²/(r² + h²))",
            scene(&[&path(2), &camera, &floor, &screen, &constant(1.0)]),
            0.5 * (1.0 - 0.49 / 1.49),
        )
        .samples(1 << 14),
        ClosedForm::new("matte_ball", furnace, ball(&diffuse(0.8)), 1.0 - 0.2 * covered()).samples(1 << 10),
    ]
}

const BALL_FOV: f64 = 32.0;

/// The share of the film that the ball covers: its outline is a circle of tangent 1/√15.
fn covered() -> f64 {
    let half = libm::tan(f64::to_radians(0.5 * BALL_FOV));
    std::f64::consts::PI / 15.0 / (4.0 * half * half)
}

/// The luminance of D65 at luminance 1 as the observer's tables give it (see `colors.rs`).
pub fn white() -> f64 {
    super::colors::color(super::colors::d65)[1]
}
