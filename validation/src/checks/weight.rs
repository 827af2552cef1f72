//! Is the weight of each sample f |cos θ| / pdf?
//!
//! Holds for every single sample, so no statistics: `weight` × `pdf` must be `value`, and the density
//! returned with the sample must be the one the model states for that direction. A χ² test of directions
//! detects neither error.

use super::{Check, Effort, always, draw, has_no_digits, relative_difference, show};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{Stream, Verdict, worst_of},
};

pub(super) const CHECK: Check = Check {
    name: "weight",
    about: "each sample's weight is value / pdf, and its pdf is the stated one",
    applies: always,
    outcomes: |scatterer, wo, seeds, effort| {
        seeds.iter().map(|&seed| run(scatterer, wo, seed, effort)).collect()
    },
};

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let mut stream = Stream::new(seed);
    let (mut checked, mut passed_over, mut blurred, mut wrong) = (0, 0, 0, 0);
    let (mut largest, mut place) = (0.0f64, None);
    for _ in 0..effort.samples.div_ceil(16) {
        let Some(sample) = draw(scatterer, wo, &mut stream).filter(|sample| !sample.delta) else { continue };
        let (value, pdf) = (scatterer.value(wo, sample.wi), scatterer.pdf(wo, sample.wi));
        // Neither weight nor value has significant digits to compare.
        if worst_of(sample.weight * pdf, value) < effort.smallest
            && relative_difference(sample.pdf, pdf) <= effort.tolerance
        {
            passed_over += 1;
            continue;
        }
        let weight = relative_difference(sample.weight * pdf, value);
        let density = relative_difference(sample.pdf, pdf);
        checked += 1;
        let blurred_by_rounding = || {
            has_no_digits(|wi| scatterer.value(wo, wi), sample.wi, effort.tolerance)
                || has_no_digits(|wi| scatterer.pdf(wo, wi), sample.wi, effort.tolerance)
        };
        if (weight > effort.tolerance || density > effort.tolerance) && blurred_by_rounding() {
            blurred += 1;
            continue;
        }
        // Not `>`: a NaN must count as wrong.
        wrong += usize::from(!(weight <= effort.tolerance && density <= effort.tolerance));
        for (error, what) in
            [(weight, "weight × pdf and value"), (density, "the sample's pdf and the stated one")]
        {
            if error.is_nan() || error > largest {
                (largest, place) = (error, Some((what, sample.wi)));
            }
        }
    }
    let verdict = if wrong == 0 { Verdict::Equivalent } else { Verdict::Different };
    let message = match place {
        Some((what, wi)) if wrong > 0 => {
            format!("{what} differ by {largest:.2e} at {}; {wrong} of {checked} samples are wrong", show(wi))
        }
        _ if checked == 0 && passed_over == 0 => "no sample outside delta lobes".to_string(),
        _ => format!(
            "{checked} samples agree within {largest:.1e}, but for {blurred} where the value has no digits"
        ),
    };
    let verdict = if 100 * blurred > checked || checked == 0 && passed_over > 0 {
        verdict.max(Verdict::Inconclusive)
    } else {
        verdict
    };
    Outcome::new("weight", verdict, message)
        .figure("checked", checked as f64)
        .figure("wrong", wrong as f64)
        .figure("worst", largest)
}
