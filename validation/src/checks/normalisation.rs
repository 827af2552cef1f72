//! Does the density integrate to the probability of drawing a direction?
//!
//! ∫pdf by adaptive quadrature against the share of draws that return a direction outside delta lobes. A
//! model that sometimes absorbs or takes a delta lobe has ∫pdf < 1, and exactly the share 1 − ∫pdf of its
//! draws must return no such direction.

use std::f64::consts::LN_10;

use super::{BLURRED, Check, Effort, always, draw, judge, partition::Partition, pilot};
use crate::{
    quadrature::Integral,
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{
        Stream, Verdict,
        binomial::{binomial_randomised, binomial_two_sided},
        power::detectable_difference,
    },
};

pub(super) const CHECK: Check = Check {
    name: "normalisation",
    about: "the pdf integrates to the probability of drawing a direction",
    applies: always,
    outcomes,
};

/// The error of the integral that must be detectable.
const MARGIN: f64 = 0.01;

const BINS: usize = 64;

/// Tolerance of the integral, in units of 1/samples.
const QUADRATURE: f64 = 1.0;

/// Least variance of the count for which its p-value is meaningful.
const BY_CHANCE: f64 = 5.0;

fn outcomes(scatterer: &dyn Scatterer, wo: DVec3, seeds: &[u64], effort: &Effort) -> Vec<Outcome> {
    let partition = Partition::adapt(scatterer, wo, &mut pilot(seeds), BINS);
    let integral: Integral = partition
        .integrate(QUADRATURE / effort.samples as f64, scatterer, |wi| scatterer.pdf(wo, wi))
        .into_iter()
        .sum();
    seeds.iter().map(|&seed| conclude(scatterer, wo, seed, effort, integral)).collect()
}

fn conclude(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort, integral: Integral) -> Outcome {
    if !(integral.value.is_finite() && integral.error.is_finite()) {
        return Outcome::new("normalisation", Verdict::Different, "the pdf is not finite").p_value(0.0);
    }
    let mut stream = Stream::new(seed);
    let draws = (0..effort.samples).filter_map(|_| draw(scatterer, wo, &mut stream));
    let drawn = draws.filter(|sample| !sample.delta).count();
    let share = drawn as f64 / effort.samples as f64;
    // Draws of this probability occur in the sample with 90 % probability.
    let unseen = LN_10 / effort.samples as f64;
    // Quadrature tells its error from what its points meet: a hole or a lobe between them is not in it.
    let error = integral.error.max(unseen);
    // Of all values within the integral's error bound, the one most favourable to the model; never more than
    // a probability.
    let kindest = share.clamp(integral.value - error, integral.value + error).clamp(0.0, 1.0);
    let p_value = binomial_two_sided(drawn as u64, effort.samples as u64, kindest);
    let spread = (kindest * (1.0 - kindest) / effort.samples as f64).sqrt();
    let detectable = detectable_difference(spread, effort.level, f64::INFINITY).max(unseen) + error;
    let excess = integral.value - integral.error > 1.0 + effort.tolerance;
    let verdict = if excess { Verdict::Different } else { judge(p_value, effort.level, detectable, MARGIN) };
    let message = format!(
        "the pdf integrates to {:.6} ± {:.1e}; {:.6} of the draws gave a direction",
        integral.value, error, share
    );
    let outcome = Outcome::new("normalisation", verdict, message)
        .detectable(detectable)
        .figure("integral", integral.value)
        .figure("integral_error", error)
        .figure("drawn", share);
    let known = integral.value.clamp(0.0, 1.0);
    let noise = (known * (1.0 - known) * effort.samples as f64).sqrt();
    if noise * noise < BY_CHANCE || integral.error * effort.samples as f64 > BLURRED * noise {
        return outcome;
    }
    outcome.p_value(binomial_randomised(drawn as u64, effort.samples as u64, known, stream.uniform()))
}
