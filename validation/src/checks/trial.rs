//! The checks on trial: honest models pass, saboteurs are rejected by the check that is there for them.

use super::{CHECKS, Effort, find, run_all};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Scatterer, direction},
    statistics::{Verdict, seed_for, sidak, uniformity},
    subjects::{Conductor, DiffuseDielectric, Fault, Lambert, Sabotaged, SmoothDielectric},
};

fn effort() -> Effort {
    Effort { samples: 1 << 17, ..Effort::default() }
}

fn run(check: &str, scatterer: &dyn Scatterer, wo: DVec3) -> Outcome {
    (find(check).unwrap().run)(scatterer, wo, seed_for(check, 0), &effort())
}

/// Steep, oblique, grazing, and from below.
fn directions() -> [DVec3; 4] {
    [DVec3::Z, direction(0.7, 0.4), direction(0.05, 2.0), direction(-0.6, -1.0)]
}

#[test]
fn honest_models_pass_every_check_at_every_roughness() {
    let conductor = |alpha: f64| Box::new(Conductor { alpha, r0: 0.9 }) as Box<dyn Scatterer>;
    let subjects: [(&str, Box<dyn Scatterer>); 9] = [
        ("lambert", Box::new(Lambert { albedo: 0.8 })),
        ("conductor 1", conductor(1.0)),
        ("conductor 0.3", conductor(0.3)),
        ("conductor 0.1", conductor(0.1)),
        ("conductor 0.01", conductor(0.01)),
        ("conductor 0.001", conductor(0.001)),
        ("conductor 0.0001", conductor(0.0001)),
        ("diffuse dielectric", Box::new(DiffuseDielectric { eta: 1.5 })),
        ("smooth dielectric", Box::new(SmoothDielectric { eta: 1.5, reflectance: 0.3 })),
    ];
    let level = sidak(0.01, subjects.len() * directions().len() * CHECKS.len());
    let effort = Effort { level, ..effort() };
    for (name, subject) in &subjects {
        for (number, wo) in (0..).zip(directions()) {
            for outcome in run_all(subject.as_ref(), wo, seed_for(name, number), &effort) {
                println!("{name} {number} {}: {}", outcome.check, outcome.message);
                assert_eq!(outcome.verdict, Verdict::Equivalent, "{name} {wo}: {outcome:?}");
            }
        }
    }
}

#[test]
fn saboteurs_are_rejected() {
    let lambert = Lambert { albedo: 0.99 };
    let conductor = Conductor { alpha: 0.2, r0: 0.9 };
    let dielectric = DiffuseDielectric { eta: 1.5 };
    let cases: [(&dyn Scatterer, Fault, &[&str]); 13] = [
        (&lambert, Fault::PdfScaled, &["normalisation", "furnace"]),
        (&conductor, Fault::PdfScaled, &["normalisation", "chi2", "furnace"]),
        (&lambert, Fault::NoCosine, &["furnace", "reciprocity"]),
        (&conductor, Fault::WeightScaled, &["weight"]),
        (&lambert, Fault::HemisphereMirrored, &["chi2", "weight"]),
        (&conductor, Fault::AzimuthMirrored, &["chi2", "weight"]),
        (&conductor, Fault::Turned, &["chi2"]),
        (&lambert, Fault::OneWay, &["reciprocity"]),
        (&dielectric, Fault::NoRadianceScaling, &["reciprocity", "furnace"]),
        (&lambert, Fault::GrazingNan, &["finiteness"]),
        (&lambert, Fault::TooBright, &["furnace"]),
        (&conductor, Fault::DrawsLost, &["normalisation", "furnace", "chi2"]),
        (&lambert, Fault::ValueScaled, &["weight", "furnace"]),
    ];
    for (honest, fault, checks) in cases {
        for check in checks {
            let outcome = run(check, &Sabotaged { honest, fault }, direction(0.7, 0.4));
            println!("{fault:?} {check}: {}", outcome.message);
            assert_eq!(outcome.verdict, Verdict::Different, "{fault:?}: {outcome:?}");
        }
    }
}

#[test]
fn p_values_of_honest_models_are_uniform() {
    let conductor = Conductor { alpha: 0.3, r0: 0.9 };
    let wo = direction(0.4, 1.0);
    let effort = Effort { samples: 1 << 14, ..Effort::default() };
    for check in ["chi2", "normalisation", "furnace"] {
        let run = find(check).unwrap().run;
        let p_values: Vec<f64> = (0..500)
            .filter_map(|number| run(&conductor, wo, seed_for(check, number), &effort).p_value)
            .collect();
        let uniform = uniformity(&p_values);
        println!("{check}: {} p-values, uniformity p = {uniform:.3}", p_values.len());
        assert!(p_values.len() == 500 && uniform > 1e-3, "{check}: {uniform}");
    }
}

#[test]
fn too_few_samples_are_inconclusive() {
    let effort = Effort { samples: 1000, ..Effort::default() };
    let outcome = (find("chi2").unwrap().run)(&Lambert { albedo: 0.5 }, DVec3::Z, 0, &effort);
    assert_eq!(outcome.verdict, Verdict::Inconclusive, "{outcome:?}");
}
