//! Tests of the checks: correct models pass, and each saboteur is rejected by the check designed for it.

use super::{CHECKS, Effort, find, run_all};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Sample, Scatterer, direction},
    statistics::{Verdict, seed_for, sidak, uniformity},
    subjects::{
        Coloured, Conductor, DiffuseDielectric, Fault, Lambert, Mixture, Near, Sabotaged, SmoothDielectric,
    },
};

fn effort() -> Effort {
    Effort { samples: 1 << 17, ..Effort::default() }
}

fn run(check: &str, scatterer: &dyn Scatterer, wo: DVec3) -> Outcome {
    find(check).unwrap().run(scatterer, wo, seed_for(check, 0), &effort())
}

/// Normal, oblique and grazing incidence, and incidence from below.
fn directions() -> [DVec3; 4] {
    [DVec3::Z, direction(0.7, 0.4), direction(0.05, 2.0), direction(-0.6, -1.0)]
}

fn mixture(alpha: f64, forgetful: bool) -> Mixture {
    Mixture {
        conductor: Conductor { alpha, r0: 0.9 },
        lambert: Lambert { albedo: 0.8 },
        share: 0.3,
        forgetful,
    }
}

#[test]
fn honest_models_pass_every_check_at_every_roughness() {
    let conductor = |alpha: f64| Box::new(Conductor { alpha, r0: 0.9 }) as Box<dyn Scatterer>;
    let mixture = |alpha: f64| Box::new(mixture(alpha, false)) as Box<dyn Scatterer>;
    let subjects: [(&str, Box<dyn Scatterer>); 12] = [
        ("mixture 0.3", mixture(0.3)),
        ("mixture 0.01", mixture(0.01)),
        ("coloured", Box::new(Coloured { nm: 550.0, beside: 500.0, leak: [0.0; 2] })),
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
                // Harmonics of low degree cannot resolve the narrowest lobes.
                let silent = outcome.check == "moments" && outcome.figures.get("components") == Some(&0.0);
                let expected = if silent { Verdict::Inconclusive } else { Verdict::Equivalent };
                assert_eq!(outcome.verdict, expected, "{name} {wo}: {outcome:?}");
            }
        }
    }
}

#[test]
fn saboteurs_are_rejected() {
    let lambert = Lambert { albedo: 0.99 };
    let conductor = Conductor { alpha: 0.2, r0: 0.9 };
    let dielectric = DiffuseDielectric { eta: 1.5 };
    let smooth = SmoothDielectric { eta: 1.5, reflectance: 0.3 };
    let cases: [(&dyn Scatterer, Fault, &[&str]); 18] = [
        (&lambert, Fault::PdfScaled, &["normalisation", "furnace"]),
        (&conductor, Fault::PdfScaled, &["normalisation", "chi2", "furnace", "jacobian"]),
        (&lambert, Fault::NoCosine, &["furnace", "reciprocity"]),
        (&conductor, Fault::WeightScaled, &["weight"]),
        (&lambert, Fault::HemisphereMirrored, &["chi2", "weight"]),
        (&conductor, Fault::AzimuthMirrored, &["chi2", "weight", "moments"]),
        (&conductor, Fault::Turned, &["chi2"]),
        (&lambert, Fault::OneWay, &["reciprocity"]),
        (&dielectric, Fault::NoRadianceScaling, &["reciprocity", "furnace"]),
        (&lambert, Fault::GrazingNan, &["finiteness"]),
        (&lambert, Fault::TooBright, &["furnace"]),
        (&conductor, Fault::DrawsLost, &["normalisation", "furnace", "chi2", "jacobian"]),
        (&lambert, Fault::ValueScaled, &["weight", "furnace"]),
        (&conductor, Fault::PdfTilted, &["jacobian"]),
        (&conductor, Fault::WeightTilted, &["moments", "weight"]),
        (&lambert, Fault::SpreadDelta, &["delta"]),
        (&smooth, Fault::UnlikelyDelta, &["delta"]),
        (&smooth, Fault::OneWayDelta, &["reciprocity", "furnace"]),
    ];
    for (honest, fault, checks) in cases {
        for check in checks {
            let outcome = run(check, &Sabotaged { honest, fault }, direction(0.7, 0.4));
            println!("{fault:?} {check}: {}", outcome.message);
            assert_eq!(outcome.verdict, Verdict::Different, "{fault:?}: {outcome:?}");
        }
    }
}

/// A matte surface that neither reflects into nor draws from a small cap of directions.
struct Holed(Lambert);

impl Holed {
    fn lacks(wi: DVec3) -> bool {
        const SHARE_OF_HEMISPHERE: f64 = 1e-5;
        wi.dot(direction(0.6, 1.2)) > 1.0 - SHARE_OF_HEMISPHERE
    }
}

impl Scatterer for Holed {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        if Self::lacks(wi) { 0.0 } else { self.0.value(wo, wi) }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if Self::lacks(wi) { 0.0 } else { self.0.pdf(wo, wi) }
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        self.0.sample(wo, u).filter(|sample| !Self::lacks(sample.wi))
    }
}

/// Quadrature does not see what lies between its points, and must not claim that there is nothing.
#[test]
fn a_hole_that_quadrature_misses_is_no_fault() {
    let check = find("normalisation").unwrap();
    let holed = Holed(Lambert { albedo: 0.8 });
    for number in 0..8 {
        let effort = Effort { samples: 1 << 18, ..effort() };
        let outcome = check.run(&holed, direction(0.7, 0.4), seed_for("a hole", number), &effort);
        assert_ne!(outcome.verdict, Verdict::Different, "{outcome:?}");
    }
}

#[test]
fn what_is_inconclusive_is_asked_again_of_more_samples() {
    let conductor = Conductor { alpha: 1.0, r0: 0.9 };
    let check = find("furnace").unwrap();
    let hasty = Effort { samples: 1 << 12, albedo: 5e-3, ..Effort::default() };
    let ask =
        |effort: &Effort| check.run(&conductor, direction(0.7, 0.4), seed_for("asked again", 0), effort);
    let (once, again) = (ask(&hasty), ask(&Effort { thorough: true, ..hasty }));
    assert_eq!([once.verdict, again.verdict], [Verdict::Inconclusive, Verdict::Equivalent]);
    assert_ne!(once.figures["sampled"], again.figures["sampled"]);
    // Whether there is a repetition depends on the result, so the p-value of the last run would not be
    // uniform.
    assert_eq!(once.p_value, again.p_value);
}

#[test]
fn a_forgotten_lobe_is_missed_by_the_jacobian() {
    for alpha in [0.3, 0.01] {
        let outcome = run("jacobian", &mixture(alpha, true), direction(0.7, 0.4));
        assert_eq!(outcome.verdict, Verdict::Different, "{outcome:?}");
    }
}

#[test]
fn leaks_between_wavelengths_are_found() {
    for leak in [[1e-3, 0.0], [0.0, 0.05]] {
        let outcome = run("spectral", &Coloured { nm: 550.0, beside: 500.0, leak }, DVec3::Z);
        assert_eq!(outcome.verdict, Verdict::Different, "{outcome:?}");
    }
}

#[test]
fn a_model_meets_its_limit_or_is_found_out() {
    let wo = direction(0.7, 0.4);
    let conductor = |alpha: f64| Conductor { alpha, r0: 1.0 };
    let (rough, near, smooth) = (conductor(0.2), conductor(1e-3), conductor(1e-4));
    let dim = Sabotaged { honest: &near, fault: Fault::TooBright };
    for (model, expected) in [
        (&near as &dyn Scatterer, Verdict::Equivalent),
        (&rough, Verdict::Different),
        (&dim, Verdict::Different),
    ] {
        let outcome = run("limits", &Near { model, limit: &smooth, within: 1e-3 }, wo);
        assert_eq!(outcome.verdict, expected, "{outcome:?}");
    }
}

#[test]
fn p_values_of_honest_models_are_uniform() {
    let conductor = Conductor { alpha: 0.3, r0: 0.9 };
    let wo = direction(0.4, 1.0);
    let effort = Effort { samples: 1 << 14, ..Effort::default() };
    for check in ["chi2", "normalisation", "furnace", "moments"] {
        // Runs of a batch share a pilot sample and integrals.
        let batch = |number: u64| {
            let seeds: Vec<u64> = (10 * number..10 * number + 10).map(|n| seed_for(check, n)).collect();
            find(check).unwrap().repeat(&conductor, wo, &seeds, &effort)
        };
        let p_values: Vec<f64> = (0..20).flat_map(batch).filter_map(|outcome| outcome.p_value).collect();
        let uniform = uniformity(&p_values);
        println!("{check}: {} p-values, uniformity p = {uniform:.3}", p_values.len());
        // These two checks give no p-value where the quadrature error is not far below the noise of the
        // samples.
        let enough = p_values.len() >= 150 || ["normalisation", "furnace"].contains(&check);
        assert!(enough && uniform > 1e-3, "{check}: {} {uniform}", p_values.len());
    }
}

#[test]
fn too_few_samples_are_inconclusive() {
    let effort = Effort { samples: 1000, ..Effort::default() };
    let outcome = find("chi2").unwrap().run(&Lambert { albedo: 0.5 }, DVec3::Z, 0, &effort);
    assert_eq!(outcome.verdict, Verdict::Inconclusive, "{outcome:?}");
}
