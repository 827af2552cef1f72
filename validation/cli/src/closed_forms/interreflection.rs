//! Interreflection in closed rooms and between mirrors.

use super::ClosedForm;
use super::irradiance::{BSDF_ONLY, EMITTER_ONLY};
use crate::stage::*;
use std::f64::consts::PI;

pub fn cases() -> Vec<ClosedForm> {
    let glow = "L = Lₑ/(1 − ρ) in a closed room that glows all over (geometric series)";
    let lamp = "a lamp in the middle of a sphere: E = I/r², L = ρE/π · Σ ρⁿ (geometric series)";
    let mut cases = vec![
        ClosedForm::new("furnace_2_of_5", glow, room("sphere", 2.0, 0.6, -1), 5.0)
            .margin(0.0025)
            .samples(1 << 16),
        ClosedForm::new("glowing_cube", glow, room("cube", 1.0, 0.5, -1), 2.0)
            .margin(0.0025)
            .samples(1 << 16),
        ClosedForm::new("lamp_with_roulette", lamp, lit_sphere(0.8, -1), 0.8 / PI / 4.0 / 0.2)
            .margin(0.0025)
            .samples(1 << 16),
    ];
    let once = "L = Lₑ(1 + ρ) in a closed room that glows all over, after one reflection";
    for (name, by) in [
        ("glow_once", path(2)),
        ("glow_once_bsdf_sampling", BSDF_ONLY.into()),
        ("glow_once_emitter_sampling", EMITTER_ONLY.into()),
    ] {
        let scene = room("sphere", 2.0, 0.6, 2).replace(&path(2), &by);
        cases.push(ClosedForm::new(name, once, scene, 3.2).margin(0.0025).samples(1 << 14));
    }
    for depth in [2, 3, 6, 40] {
        let sum: f64 = (0..depth - 1).map(|n| libm::pow(0.8, f64::from(n))).sum();
        let scene = lit_sphere(0.8, i64::from(depth));
        let expected = 0.8 / PI / 4.0 * sum;
        cases.push(ClosedForm::new(format!("lamp_depth_{depth}"), lamp, scene, expected).samples(1 << 8));
    }
    for depth in [1, 2, 5, 30] {
        let source = "two glowing mirrors, seen head-on: L = (1 − Rᵐ)/(1 − R) after m edges";
        let expected = (1.0 - libm::pow(0.9, f64::from(depth))) / (1.0 - 0.9);
        let scene = facing_mirrors(i64::from(depth));
        cases
            .push(ClosedForm::new(format!("mirrors_depth_{depth}"), source, scene, expected).samples(1 << 6));
    }
    let source = "two glowing mirrors, seen head-on: L = 1/(1 − R)";
    cases.push(
        ClosedForm::new("mirrors_with_roulette", source, facing_mirrors(-1), 10.0)
            .margin(0.0025)
            .samples(1 << 16),
    );
    for bounces in [1, 7, 20] {
        let source = "a corridor of mirrors: L = Rⁿ after n reflections (unfolding)";
        let expected = libm::pow(0.95, f64::from(bounces));
        let scene = corridor(bounces);
        cases.push(ClosedForm::new(format!("corridor_{bounces}"), source, scene, expected).samples(1 << 6));
    }
    cases
}

/// A hollow shape, seen from a point inside other than its centre.
fn room(kind: &str, radiance: f64, reflectance: f64, depth: i64) -> String {
    let inside = "<boolean name=\"flip_normals\" value=\"true\"/>";
    let wall = shape(kind, &[], &(inside.to_string() + &area(radiance) + &diffuse(reflectance)));
    scene(&[&path(depth), &pointed([0.3, 0.2, -0.1], [0.5, -0.3, 0.7]), &wall])
}

/// A sphere of radius 2 with a point light of intensity 1 at its centre.
fn lit_sphere(reflectance: f64, depth: i64) -> String {
    let inside = "<boolean name=\"flip_normals\" value=\"true\"/>";
    let wall = sphere([0.0; 3], 2.0, &(inside.to_string() + &diffuse(reflectance)));
    let lamp = emitter("point", &grey("intensity", 1.0));
    scene(&[&path(depth), &pointed([0.3, 0.2, -0.1], [0.5, -0.3, 0.7]), &wall, &lamp])
}

/// Two mirrors of reflectance 0.9 and radiance 1, and a ray perpendicular to both.
fn facing_mirrors(depth: i64) -> String {
    let wears = bsdf("conductor", &grey("specular_reflectance", 0.9)) + &area(1.0);
    let below = shape("rectangle", &[], &wears);
    let above = shape("rectangle", &[rotate('x', 180.0), translate([0.0, 0.0, 1.0])], &wears);
    scene(&[&path(depth), &pointed([0.1, 0.2, 0.5], [0.1, 0.2, 0.0]), &below, &above])
}

/// Mirrors of reflectance 0.95 at z = ±½; a ray at 45° meets one per unit of x and finally a light across the
/// corridor.
fn corridor(bounces: i32) -> String {
    let mirror = bsdf("conductor", &grey("specular_reflectance", 0.95));
    let wide = scale([100.0, 1.0, 1.0]);
    let below = shape("rectangle", &[wide.clone(), translate([0.0, 0.0, -0.5])], &mirror);
    let above = shape("rectangle", &[wide, rotate('x', 180.0), translate([0.0, 0.0, 0.5])], &mirror);
    // From the middle of the corridor: reflections at x = ½, 1½, …
    let light =
        shape("rectangle", &[rotate('y', -90.0), translate([f64::from(bounces), 0.0, 0.0])], &area(1.0));
    let camera = pointed([0.0; 3], [1.0, 0.0, 1.0]);
    scene(&[&path(i64::from(bounces) + 1), &camera, &below, &above, &light])
}
