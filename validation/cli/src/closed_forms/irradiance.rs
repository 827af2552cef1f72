//! Irradiance from lights with straight edges.

use super::{ClosedForm, lambert};
use crate::stage::*;
use std::f64::consts::PI;
use validation::scatterer::DVec3;

/// Reflectance of the floor that shows the irradiance E: its radiance is ρE/π.
const REFLECTANCE: f64 = 0.5;

/// A diffuse floor around the origin, seen at the origin, under these lights.
pub fn floor_under(lights: &str) -> String {
    let floor = shape("rectangle", &[], &diffuse(REFLECTANCE));
    scene(&[&path(2), &pointed([-1.5, -2.0, 1.5], [0.0; 3]), &floor, lights])
}

/// The radiance of the floor at an irradiance.
pub fn shown(irradiance: f64) -> f64 {
    REFLECTANCE / PI * irradiance
}

pub fn cases() -> Vec<ClosedForm> {
    let lambert = "E = ½ Σ θᵢ n·Γᵢ (Lambert 1760; Arvo 1995, eq. 2.7)";
    vec![
        ClosedForm::new("parallel_rectangle", lambert, floor_under(&parallel()), shown(parallel_answer())),
        ClosedForm::new("perpendicular_rectangle", lambert, floor_under(&wall()), shown(wall_answer())),
        ClosedForm::new("cube", lambert, floor_under(&cube()), shown(cube_answer())).samples(1 << 14),
        ClosedForm::new(
            "parallel_rectangle_bsdf_sampling",
            lambert,
            floor_under(&parallel()).replace(&path(2), BSDF_ONLY),
            shown(parallel_answer()),
        )
        .samples(1 << 16),
        ClosedForm::new(
            "parallel_rectangle_emitter_sampling",
            lambert,
            floor_under(&parallel()).replace(&path(2), EMITTER_ONLY),
            shown(parallel_answer()),
        ),
    ]
}

pub(super) const BSDF_ONLY: &str = "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"0\"/>\
     <integer name=\"bsdf_samples\" value=\"1\"/></integrator>";
pub(super) const EMITTER_ONLY: &str = "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"1\"/>\
     <integer name=\"bsdf_samples\" value=\"0\"/></integrator>";

/// A light of 1 × 0.6 at height 0.8, with one corner above the point.
fn parallel() -> String {
    let steps = [scale([0.5, 0.3, 1.0]), rotate('x', 180.0), translate([0.5, 0.3, 0.8])];
    shape("rectangle", &steps, &area(1.0))
}

fn parallel_answer() -> f64 {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.6), (0.0, 0.6)];
    lambert::irradiance(&corners.map(|(x, y)| DVec3::new(x, y, 0.8)))
}

/// A light in the plane x = 0.5, −0.4 ≤ y ≤ 0.9, 0 ≤ z ≤ 0.7, facing the point.
fn wall() -> String {
    let steps = [scale([0.35, 0.65, 1.0]), rotate('y', -90.0), translate([0.5, 0.25, 0.35])];
    shape("rectangle", &steps, &area(1.0))
}

fn wall_answer() -> f64 {
    let corners = [(-0.4, 0.0), (0.9, 0.0), (0.9, 0.7), (-0.4, 0.7)];
    lambert::irradiance(&corners.map(|(y, z)| DVec3::new(0.5, y, z)))
}

const CUBE: (f64, f64, Point) = (0.2, 30.0, [0.3, 0.4, 0.8]);

/// A cube of edge length 0.4, rotated by 30° about z.
fn cube() -> String {
    let (half, degrees, place) = CUBE;
    shape("cube", &[scale([half; 3]), rotate('z', degrees), translate(place)], &area(1.0))
}

/// The sum over the faces that face the point.
fn cube_answer() -> f64 {
    let (half, degrees, place) = CUBE;
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let turn = |v: DVec3| DVec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut sum = 0.0;
    for i in 0..3 {
        for sign in [-1.0, 1.0] {
            let (n, s, t) = (axes[i] * sign, axes[(i + 1) % 3], axes[(i + 2) % 3]);
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| turn((n + s * x + t * y) * half) + DVec3::from_array(place));
            if turn(n).dot(corners[0]) < 0.0 {
                sum += lambert::irradiance(&corners);
            }
        }
    }
    sum
}
