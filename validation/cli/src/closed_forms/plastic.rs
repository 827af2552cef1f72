//! A diffuse base under a clear coat.

use super::ClosedForm;
use super::interfaces::reflectance;
use crate::stage::*;

const ETA: f64 = 1.5;

pub fn cases() -> Vec<ClosedForm> {
    let source = "R + (1 − R)(1 − F)ρ/(η²(1 − ρ′Fᵢ)), ρ′ = ρ or 1, F and Fᵢ the diffuse reflectances of the coat; \
                  1 − Fᵢ = (1 − F)/η² (Egan & Hilgeman 1979, §6.4); the model's Fᵢ is Mitsuba's fit, 0.2 % off";
    let mut cases = vec![];
    for (nonlinear, degrees) in [(false, 0.0), (false, 70.0), (true, 30.0)] {
        let more = format!("<boolean name=\"nonlinear\" value=\"{nonlinear}\"/>");
        let index = float("int_ior", ETA) + &float("ext_ior", 1.0);
        let wears = bsdf("plastic", &(grey("diffuse_reflectance", RHO) + &index + &more));
        let (sin, cos) = libm::sincos(f64::to_radians(degrees));
        let camera = pointed([5.0 * sin, 0.0, 5.0 * cos], [0.0; 3]);
        let scene = scene(&[&path(2), &camera, &shape("rectangle", &[], &wears), &constant(1.0)]);
        let name = format!("{}_{degrees}", if nonlinear { "nonlinear" } else { "linear" });
        let case = ClosedForm::new(name, source, scene, answer(nonlinear, degrees));
        cases.push(case.margin(0.0025).samples(1 << 14));
    }
    cases
}

const RHO: f64 = 0.6;

fn answer(nonlinear: bool, degrees: f64) -> f64 {
    // F = ∫ R(θ) 2 sin θ cos θ dθ, by the midpoint rule in sin²θ.
    const STEPS: u32 = 100_000;
    let at = |i: u32| reflectance(libm::asin((f64::from(i) + 0.5) / f64::from(STEPS)).to_degrees(), ETA);
    // 2 sin θ cos θ dθ = 2s ds
    let step = |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(STEPS) / f64::from(STEPS);
    let outside: f64 = (0..STEPS).map(|i| at(i) * step(i)).sum();
    let inside = 1.0 - (1.0 - outside) / (ETA * ETA);
    let returned = if nonlinear { RHO } else { 1.0 } * inside;
    let r = reflectance(degrees, ETA);
    r + (1.0 - r) * (1.0 - outside) * RHO / (ETA * ETA * (1.0 - returned))
}
