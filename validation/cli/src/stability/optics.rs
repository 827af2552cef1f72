//! Extreme interfaces, metals and roughnesses.

use super::Case;
use super::surfaces::panes;
use crate::closed_forms::ClosedForm;
use crate::closed_forms::interfaces::{GROUND, SKY, reflectance, stage};
use crate::closed_forms::metals;
use crate::stage::*;
use etalon::bsdf::fresnel::conductor;
use etalon::spectrum::materials;
use std::f64::consts::PI;
use validation::microfacet::{Rough, Slopes};
use validation::statistics::worst_of;

pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = [interfaces(), roughness()].concat().into_iter().map(Case::answer).collect();
    cases.push(Case::at_most(
        "metals_at_the_ends",
        "R of Au, Ag, Cu and Al at 360 and 830 nm to 10⁻⁷ rad of grazing, by complex arithmetic (Born & Wolf §14.2): 10⁻¹²",
        1e-12,
        Box::new(|_| metals_at_the_ends()),
    ));
    cases
}

fn interfaces() -> Vec<ClosedForm> {
    let glass = |eta: f64| bsdf("dielectric", &(float("int_ior", eta) + &float("ext_ior", 1.0)));
    let pane = |eta: f64| shape("rectangle", &[scale([100.0; 3])], &glass(eta));
    let fresnel = "Fresnel's equations (Born & Wolf §1.5.2)";
    let mut cases = vec![];
    for eta in [1e-4, 0.1, 10.0, 1e4] {
        let expected = reflectance(0.0, eta);
        cases.push(
            ClosedForm::new(format!("eta_{eta:e}"), fresnel, stage(0.0, SKY, &pane(eta)), expected)
                .samples(1 << 12),
        );
    }
    for eta in [1.0 + 1e-7, 1.0 - 1e-7] {
        let expected = 1.0 / (eta * eta);
        let scene = stage(89.0, GROUND, &pane(eta));
        cases.push(ClosedForm::new(format!("eta_{eta}"), "an interface of 10⁻⁷ is none", scene, expected));
    }
    let m = 200.0;
    let r = reflectance(0.0, 1.5);
    let source = "100 panes reflect mR/(1 + (m − 1)R), m = 200 (Stokes 1862)";
    let scene = stage(0.0, SKY, &panes(100, 0.01, 0.02)).replace(&path(-1), &path(1_000_000));
    cases.push(
        ClosedForm::new("panes_100", source, scene, m * r / (1.0 + (m - 1.0) * r))
            .margin(0.0025)
            .samples(1 << 14),
    );
    cases.push(chain(1000));
    cases
}

/// A light guide of glass between z = ±½: a ray at 45° is reflected at x = ½, 1½, … and meets a narrow light.
fn chain(bounces: i32) -> ClosedForm {
    let glass = bsdf("dielectric", &(float("int_ior", 1.5) + &float("ext_ior", 1.0)));
    let wide = scale([2000.0, 10.0, 1.0]);
    let above = shape("rectangle", &[wide.clone(), translate([0.0, 0.0, 0.5])], &glass);
    let below = shape("rectangle", &[wide, rotate('x', 180.0), translate([0.0, 0.0, -0.5])], &glass);
    // The width of the camera's beam, 10⁻⁵ rad, is 0.014 there.
    let place = [scale([0.02; 3]), rotate('y', -90.0), translate([f64::from(bounces), 0.0, 0.0])];
    let light = shape("rectangle", &place, &area(1.0));
    let camera = pointed([0.0; 3], [1.0, 0.0, 1.0]);
    let scene = scene(&[&path(i64::from(bounces) + 1), &camera, &below, &above, &light]);
    ClosedForm::new(
        format!("total_reflection_{bounces}"),
        "total internal reflection loses nothing, and goes straight",
        scene,
        1.0,
    )
    .samples(64)
}

fn roughness() -> Vec<ClosedForm> {
    let mirror = |degrees: f64, parameters: &str| {
        let pane = shape(
            "rectangle",
            &[scale([0.01; 3])],
            &bsdf(
                "roughconductor",
                &(grey("specular_reflectance", 1.0)
                    + "<string name=\"material\" value=\"none\"/><string name=\"distribution\" value=\"ggx\"/>"
                    + parameters),
            ),
        );
        stage(degrees, &constant(1.0), &pane).replace(&path(-1), &path(2))
    };
    let mut cases = vec![];
    for alpha in [1e-6, 1e-4, 1e-2, 0.1, 1.0] {
        let source = "what facets that are met once return (Walter et al. 2007)";
        let expected =
            Rough { slopes: Slopes::Ggx, alpha, eta: None }.albedo(libm::cos(PI / 6.0), 1e-5).value;
        cases.push(
            ClosedForm::new(
                format!("roughness_{alpha:e}"),
                source,
                mirror(30.0, &float("alpha", alpha)),
                expected,
            )
            .samples(1 << 15),
        );
    }
    let source = "facets sloped along one axis: ∫ G₁(r)/2(1 + x²)^{3/2} dx, tan r = 2x/(1 − x²)";
    let scene = mirror(0.0, &(float("alpha_u", 1.0) + &float("alpha_v", 1e-4)));
    cases.push(ClosedForm::new("anisotropy_1e4", source, scene, one_axis()).margin(0.0025).samples(1 << 15));
    cases
}

/// The albedo at normal incidence, by the midpoint rule.
fn one_axis() -> f64 {
    const STEPS: i32 = 100_000;
    let at = |i: i32| {
        let x = (f64::from(i) + 0.5) / f64::from(STEPS);
        let tan = 2.0 * x / (1.0 - x * x);
        let masking = 2.0 / (1.0 + (1.0 + tan * tan).sqrt());
        let q = 1.0 + x * x;
        masking / (q * q.sqrt())
    };
    (0..STEPS).map(at).sum::<f64>() / f64::from(STEPS)
}

fn metals_at_the_ends() -> Result<f64, String> {
    let mut worst: f64 = 0.0;
    for name in ["Au", "Ag", "Cu", "Al"] {
        let (eta, k) = materials::conductor(name)?;
        for nm in [360.0, 830.0] {
            let (eta, k) = (f64::from(eta.eval(nm)), f64::from(k.eval(nm)));
            for cos in [1e-7, 1e-3, 0.5, 1.0] {
                worst = worst_of(worst, conductor(cos, eta, k) / metals::reflectance(cos, eta, k) - 1.0);
            }
        }
    }
    Ok(worst)
}
