//! Smooth dielectric interfaces and stacks of them.

use super::ClosedForm;
use crate::stage::*;

const FRESNEL: &str = "Fresnel's equations for unpolarised light (Born & Wolf §1.5.2)";
const ETA: f64 = 1.5;

pub fn cases() -> Vec<ClosedForm> {
    let glass = bsdf("dielectric", &(float("int_ior", ETA) + &float("ext_ior", 1.0)));
    let schlick = glass.replace("</bsdf>", "<string name=\"fresnel\" value=\"schlick\"/></bsdf>");
    let pane = |wears: &str| shape("rectangle", &[scale([100.0, 100.0, 1.0])], wears);
    let mut cases = vec![];
    for degrees in [0.0, 45.0, 56.309_932_474_020_21, 80.0] {
        let (scene, r) = (stage(degrees, SKY, &pane(&glass)), reflectance(degrees, ETA));
        cases.push(ClosedForm::new(format!("reflection_{degrees:.0}"), FRESNEL, scene, r).samples(1 << 14));
    }
    let radiance = "L = (1 − R)L′/η²: radiance over η² is what goes through (Veach 1997, §5.2)";
    for degrees in [0.0, 60.0] {
        let scene = stage(degrees, GROUND, &pane(&glass));
        let expected = (1.0 - reflectance(degrees, ETA)) / (ETA * ETA);
        cases.push(ClosedForm::new(format!("out_of_glass_{degrees}"), radiance, scene, expected));
    }
    for degrees in [0.0, 30.0, 41.0] {
        let scene = stage(180.0 - degrees, SKY, &pane(&glass));
        let expected = (1.0 - reflectance(degrees, 1.0 / ETA)) * ETA * ETA;
        cases.push(ClosedForm::new(format!("into_glass_{degrees}"), radiance, scene, expected));
    }
    for degrees in [41.9, 60.0, 89.0] {
        let source = "total internal reflection beyond asin(1/1.5) = 41.81°";
        let scene = stage(180.0 - degrees, GROUND, &pane(&glass));
        cases.push(ClosedForm::new(format!("total_reflection_{degrees}"), source, scene, 1.0));
    }
    for degrees in [0.0, 60.0, 80.0] {
        let source = "R₀ + (1 − R₀)(1 − cos θ)⁵ (Schlick 1994, eq. 15)";
        let r0 = (ETA - 1.0) * (ETA - 1.0) / ((ETA + 1.0) * (ETA + 1.0));
        let m = 1.0 - libm::cos(f64::to_radians(degrees));
        let expected = r0 + (1.0 - r0) * m * m * m * m * m;
        let scene = stage(degrees, SKY, &pane(&schlick));
        cases.push(ClosedForm::new(format!("schlick_{degrees}"), source, scene, expected).samples(1 << 14));
    }
    cases.extend(stacks(&glass));
    cases
}

/// M parallel interfaces, each reflecting the share r of the arriving light, together reflect R = Mr/(1 + (M
/// − 1)r) (Stokes 1862, for a pile of plates).
fn stacks(glass: &str) -> Vec<ClosedForm> {
    let source = "R = Mr/(1 + (M − 1)r) of M interfaces, without interference (Stokes 1862, pile of plates)";
    let mut cases = vec![];
    for (panes, degrees) in [(1, 45.0), (3, 45.0), (8, 0.0)] {
        let thin = bsdf("thindielectric", &(float("int_ior", ETA) + &float("ext_ior", 1.0)));
        let stack: String = (0..panes)
            .map(|i| {
                let place = translate([0.0, 0.0, -0.01 * f64::from(i)]);
                shape("rectangle", &[scale([100.0, 100.0, 1.0]), place], &thin)
            })
            .collect();
        let reflected = pile(2 * panes, reflectance(degrees, ETA));
        for (what, light, expected) in [("reflect", SKY, reflected), ("transmit", GROUND, 1.0 - reflected)] {
            let name = format!("{panes}_thin_panes_{what}");
            let case = ClosedForm::new(name, source, stage(degrees, light, &stack), expected);
            // Few paths cross many panes.
            cases.push(case.margin(0.0025).samples((panes as u64) << 15));
        }
    }
    let slabs = 3;
    let slab = |i: i32| {
        let top = -0.1 * f64::from(i);
        let face = |steps: &[String], z: f64| {
            let steps = [&[scale([100.0, 100.0, 1.0])], steps, &[translate([0.0, 0.0, z])]].concat();
            shape("rectangle", &steps, glass)
        };
        face(&[], top) + &face(&[rotate('x', 180.0)], top - 0.05)
    };
    let stack: String = (0..slabs).map(slab).collect();
    let reflected = pile(2 * slabs, reflectance(50.0, ETA));
    let both = [("reflect", SKY, reflected, 1 << 18), ("transmit", GROUND, 1.0 - reflected, 1 << 17)];
    for (what, light, expected, samples) in both {
        let name = format!("{slabs}_slabs_{what}");
        let case = ClosedForm::new(name, source, stage(50.0, light, &stack), expected);
        cases.push(case.margin(0.0025).samples(samples));
    }
    cases
}

fn pile(interfaces: i32, r: f64) -> f64 {
    let m = f64::from(interfaces);
    m * r / (1.0 + (m - 1.0) * r)
}

/// A plane of radiance 1 high above, facing down.
pub const SKY: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"1000\"/>\
     <rotate x=\"1\" angle=\"180\"/><translate z=\"10\"/></transform>\
     <emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>";
/// A plane of radiance 1 far below, facing up.
pub const GROUND: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"1000\"/>\
     <translate z=\"-10\"/></transform>\
     <emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>";

/// A scene with `what` at the origin, seen from a distance of 5 at an angle from +z.
pub fn stage(degrees: f64, light: &str, what: &str) -> String {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    scene(&[&path(-1), &pointed([5.0 * sin, 0.0, 5.0 * cos], [0.0; 3]), what, light])
}

/// Reflectance, averaged over both polarisations, for a ray at this angle in the nearer medium; `eta` = n far
/// / n near.
///
/// r⊥ = sin(θ − θ′)/sin(θ + θ′), r∥ = tan(θ − θ′)/tan(θ + θ′) (Born & Wolf, eq. 1.5.21a); the renderer uses
/// cosines.
pub fn reflectance(degrees: f64, eta: f64) -> f64 {
    let near = degrees.to_radians();
    if near == 0.0 {
        return (eta - 1.0) * (eta - 1.0) / ((eta + 1.0) * (eta + 1.0));
    }
    let far = libm::asin(libm::sin(near) / eta);
    let s = libm::sin(near - far) / libm::sin(near + far);
    let p = libm::tan(near - far) / libm::tan(near + far);
    0.5 * (s * s + p * p)
}
