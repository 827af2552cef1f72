//! Is the distribution reciprocal?
//!
//! f(wo, wi) / η(wo)² = f(wi, wo) / η(wi)² (Veach 1997, eq. 5.14), for individual pairs of directions, both
//! sampled from the model and uniform over the sphere.

use std::f64::consts::{PI, TAU};

use super::{Check, Effort, draw, has_no_digits, relative_difference, show};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Laws, Scatterer, direction},
    statistics::{Stream, Verdict, worst_of},
};

pub(super) const CHECK: Check = Check {
    name: "reciprocity",
    about: "f(wo, wi) / η(wo)² is symmetric",
    applies: |scatterer| scatterer.laws().reciprocal,
    outcomes: |scatterer, wo, seeds, effort| {
        seeds.iter().map(|&seed| run(scatterer, wo, seed, effort)).collect()
    },
};

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let laws = scatterer.laws();
    let mut stream = Stream::new(seed);
    let (mut checked, mut blurred, mut wrong) = (0, 0, 0);
    let (mut largest, mut place, mut silent) = (0.0f64, wo, true);
    for turn in 0..effort.samples.div_ceil(16) {
        let uniform = direction(2.0 * stream.uniform() - 1.0, TAU * stream.uniform() - PI);
        let sampled = draw(scatterer, wo, &mut stream).filter(|sample| !sample.delta);
        let wi = sampled.filter(|_| turn % 2 == 0).map_or(uniform, |sample| sample.wi);
        let one_way = reduced(scatterer, &laws, wo, wi);
        let other_way = reduced(scatterer, &laws, wi, wo);
        // Finite, but without significant digits to compare.
        if worst_of(one_way, other_way) < effort.smallest {
            silent &= one_way == 0.0 && other_way == 0.0;
            continue;
        }
        let error = relative_difference(one_way, other_way);
        checked += 1;
        let blurred_by_rounding = || {
            has_no_digits(|wi| reduced(scatterer, &laws, wo, wi), wi, effort.tolerance)
                || has_no_digits(|wi| reduced(scatterer, &laws, wi, wo), wi, effort.tolerance)
        };
        if error > effort.tolerance && blurred_by_rounding() {
            blurred += 1;
            continue;
        }
        wrong += usize::from(error.is_nan() || error > effort.tolerance);
        if error.is_nan() || error > largest {
            (largest, place) = (error, wi);
        }
    }
    let verdict = match (wrong, checked) {
        // There is light, but never enough to compare.
        (0, 0) if !silent => Verdict::Inconclusive,
        // For example near a critical angle, where the Fresnel factor changes with every digit of a cosine.
        (0, _) if 100 * blurred > checked => Verdict::Inconclusive,
        (0, _) => Verdict::Equivalent,
        _ => Verdict::Different,
    };
    let message = if wrong == 0 && checked == 0 {
        if silent { "no light outside delta lobes" } else { "no pair has digits to compare" }.to_string()
    } else if wrong == 0 {
        format!("{checked} pairs agree within {largest:.1e}, but for {blurred} where the value has no digits")
    } else {
        format!(
            "both ways differ by {largest:.2e} for wi = {}; {wrong} of {checked} pairs are wrong",
            show(place)
        )
    };
    Outcome::new("reciprocity", verdict, message).figure("checked", checked as f64).figure("worst", largest)
}

/// f(wo, wi) / η(wo)².
fn reduced(scatterer: &dyn Scatterer, laws: &Laws, wo: DVec3, wi: DVec3) -> f64 {
    let cosine = if scatterer.is_phase_function() { 1.0 } else { wi.z.abs() };
    let index = laws.index(wo);
    scatterer.value(wo, wi) / (cosine * index * index)
}
