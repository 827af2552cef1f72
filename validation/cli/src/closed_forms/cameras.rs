//! Projections of cameras: shares of the film that an object covers.

use super::ClosedForm;
use crate::stage::*;
use std::f64::consts::PI;

const FOV: f64 = 40.0;

pub fn cases() -> Vec<ClosedForm> {
    let mut cases = field_of_view();
    let place = to_world(&[look_at([0.0, 0.0, 5.0], [0.0; 3], [0.0, 1.0, 0.0])]);
    let film = film(6, 6);
    let camera = format!("<sensor type=\"orthographic\">{place}{film}</sensor>");
    let ball = sphere([0.1, -0.2, 0.0], 0.6, &area(1.0));
    cases.push(
        ClosedForm::new(
            "orthographic_ball",
            "πr²/4 of a film 2 wide",
            scene(&[&path(1), &camera, &ball]),
            0.09 * PI,
        )
        .samples(1 << 14),
    );
    let (half, degrees) = (libm::tan(f64::to_radians(0.5 * FOV)), 12.0);
    let (sin, cos) = libm::sincos(f64::to_radians(degrees));
    let (distance, radius) = (6.0, 0.7);
    let camera = pinhole(&look_at([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]), FOV, &film);
    let ball = sphere([distance * sin, 0.0, distance * cos], radius, &area(1.0));
    // A cone of half-angle σ at an angle θ to the axis meets the film in an ellipse of half-axes
    // sin σ cos σ/(cos²θ − sin²σ) and sin σ/√(cos²θ − sin²σ).
    let sin2 = radius * radius / (distance * distance);
    let gap = cos * cos - sin2;
    let ellipse = PI * sin2 * (1.0 - sin2).sqrt() / (gap * gap.sqrt());
    cases.push(
        ClosedForm::new(
            "ball_off_axis",
            "π sin²σ cos σ/(cos²θ − sin²σ)^{3/2} of a film 4 tan²(fov/2) large (conic section)",
            scene(&[&path(1), &camera, &ball]),
            ellipse / (4.0 * half * half),
        )
        .samples(1 << 15),
    );
    let plane = shape("rectangle", &[scale([100.0; 3]), translate([0.0, 0.0, 3.0])], "");
    let depth = scene(&["<integrator type=\"depth\"/>", &camera, &plane]);
    cases.push(
        ClosedForm::new(
            "mean_distance_of_a_wall",
            "mean of (d − near)√(1 + x² + y²) over the film: rays begin at `near_clip`, as in Mitsuba (midpoint rule)",
            depth,
            (3.0 - 0.01) * mean_secant(half),
        )
        .measure(|image| image.channels.first().map_or(f64::NAN, |c| c.mean.iter().sum::<f64>() / c.mean.len() as f64)),
    );
    cases
}

/// A luminous square seen by a film of 3 × 2, for each axis to which the field of view may refer.
fn field_of_view() -> Vec<ClosedForm> {
    let half = libm::tan(f64::to_radians(0.5 * FOV));
    let square = shape(
        "rectangle",
        &[scale([0.15; 3]), rotate('x', 180.0), translate([0.05, -0.03, 1.0])],
        &area(1.0),
    );
    let place = look_at([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    // Half the width of the film at distance 1; half its height is 2/3 of that.
    let widths = [
        ("x", half),
        ("y", 1.5 * half),
        ("smaller", 1.5 * half),
        ("larger", half),
        ("diagonal", half * 3.0 / 13f64.sqrt()),
    ];
    let case = |(axis, width): (&str, f64)| {
        let named = format!("name=\"fov_axis\" value=\"{axis}\"");
        let camera = pinhole(&place, FOV, &film(3, 2)).replace("name=\"fov_axis\" value=\"x\"", &named);
        let expected = 0.3 * 0.3 / (2.0 * width * 2.0 * width * 2.0 / 3.0);
        let source = "share of a film whose half-width along the axis is tan(fov/2)";
        let scene = scene(&[&path(1), &camera, &square]);
        ClosedForm::new(format!("fov_{axis}"), source, scene, expected).samples(1 << 14)
    };
    widths.into_iter().map(case).collect()
}

fn mean_secant(half: f64) -> f64 {
    const STEPS: u32 = 400;
    let at = |i: u32| half * (f64::from(i) + 0.5) / f64::from(STEPS);
    let row = |y: f64| (0..STEPS).map(|i| (1.0 + at(i) * at(i) + y * y).sqrt()).sum::<f64>();
    (0..STEPS).map(|j| row(at(j))).sum::<f64>() / f64::from(STEPS * STEPS)
}
