//! Does the density integrate to the probability of drawing a direction?
//!
//! ∫pdf by adaptive quadrature against the share of draws that return a direction outside delta lobes. A model that
//! sometimes absorbs or takes a delta lobe has ∫pdf < 1, and exactly that share must come back empty.

use super::{Check, Effort, always, draw, judge, partition::Partition};
use crate::{
    quadrature::Integral,
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{
        Stream, Verdict, distributions::binomial_two_sided, power::detectable_difference, seed_for,
    },
};

pub(super) const CHECK: Check = Check {
    name: "normalisation",
    about: "the pdf integrates to the probability of drawing a direction",
    applies: always,
    run,
};

/// The error of the integral that must be detectable.
const MARGIN: f64 = 0.01;

const BINS: usize = 64;

/// Error of the integral, in samples.
const QUADRATURE: f64 = 1.0;

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let partition = Partition::adapt(scatterer, wo, &mut Stream::new(seed_for("pilot", seed)), BINS);
    let mut stream = Stream::new(seed);
    let draws = (0..effort.samples).filter_map(|_| draw(scatterer, wo, &mut stream));
    let drawn = draws.filter(|sample| !sample.delta).count();
    let integral: Integral =
        partition.integrate(QUADRATURE / effort.samples as f64, |wi| scatterer.pdf(wo, wi)).into_iter().sum();
    let share = drawn as f64 / effort.samples as f64;
    // Of all values the integral may have, the one that is kindest to the model; never more than a probability.
    let kindest =
        share.clamp(integral.value - integral.error, integral.value + integral.error).clamp(0.0, 1.0);
    let p_value = binomial_two_sided(drawn as u64, effort.samples as u64, kindest);
    let spread = (kindest * (1.0 - kindest) / effort.samples as f64).sqrt();
    let detectable = detectable_difference(spread, effort.level) + integral.error;
    let excess = integral.value - integral.error > 1.0 + effort.tolerance;
    let verdict = if !integral.value.is_finite() || excess {
        Verdict::Different
    } else {
        judge(p_value, effort.level, detectable, MARGIN)
    };
    let message = format!(
        "the pdf integrates to {:.6} ± {:.1e}; {:.6} of the draws gave a direction",
        integral.value, integral.error, share
    );
    let outcome = Outcome::new("normalisation", verdict, message)
        .detectable(detectable)
        .figure("integral", integral.value)
        .figure("integral_error", integral.error)
        .figure("drawn", share);
    // Where every draw (or none) gives a direction there is no chance involved, and p would always be 1.
    if drawn == 0 || drawn == effort.samples { outcome } else { outcome.p_value(p_value) }
}
