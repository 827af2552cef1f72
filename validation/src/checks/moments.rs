//! Do weighted samples have the directional distribution of the value? All low spherical harmonics at once.
//!
//! E[weight · Y_lm(ωi)] against ∫ f |cos θ| Y_lm dω by quadrature, for l ≤ 8 (l ≤ 4 in tests), judged
//! together by Hotelling's T². Detects what neither `chi2` (which tests directions without weights) nor
//! `furnace` (which tests weights without directions) detects alone, such as light moved from one side to the
//! other. Blind to errors that value and sample share, and to errors finer than a few tens of degrees.

use super::{Check, Effort, always, draw, harmonics::harmonics, judge, partition::Partition, pilot};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{
        Stream, Verdict,
        hotelling::{Components, Covariance, Expected, hotelling},
        power::detectable_chi_square,
    },
};

pub(super) const CHECK: Check = Check {
    name: "moments",
    about: "weighted samples have the spherical harmonics of the value",
    applies: always,
    outcomes,
};

/// The shift of the mean, in standard deviations of one sample, that must be detectable.
const MARGIN: f64 = 0.05;

const BINS: usize = 64;

/// Tolerance of the integrals in units of 1/√samples, the order of a mean's standard error.
const QUADRATURE: f64 = 1e-4;

/// Tolerance of the expected variances.
const ROUGHLY: f64 = 1e-3;

/// Least number of pilot samples that estimate what the judged samples may have missed.
const OTHERS: usize = 1 << 14;

/// Tests use 1/`SHARE` of the samples, because harmonics cost more than samples do.
const SHARE: usize = 4;

fn outcomes(scatterer: &dyn Scatterer, wo: DVec3, seeds: &[u64], effort: &Effort) -> Vec<Outcome> {
    if effort.thorough {
        run_to::<81>(scatterer, wo, seeds, effort.samples, effort.level)
    } else {
        run_to::<25>(scatterer, wo, seeds, effort.samples.div_ceil(SHARE), effort.level)
    }
}

fn run_to<const N: usize>(
    scatterer: &dyn Scatterer,
    wo: DVec3,
    seeds: &[u64],
    samples: usize,
    level: f64,
) -> Vec<Outcome> {
    let partition = Partition::adapt(scatterer, wo, &mut pilot(seeds), BINS);
    let tolerance = QUADRATURE / (samples as f64).sqrt();
    let (exact, error) = partition.integrate_all::<N>(tolerance, scatterer, |wi| {
        let value = scatterer.value(wo, wi);
        if value == 0.0 { [0.0; N] } else { harmonics::<N>(wi).map(|y| y * value) }
    });
    // E[weight² Y²] = ∫ f² cos² θ Y² / pdf. The quadrature error is subtracted, so that the variance is a
    // lower bound.
    let (squares, blur) = partition.integrate_all::<N>(ROUGHLY, scatterer, |wi| {
        let (value, pdf) = (scatterer.value(wo, wi), scatterer.pdf(wo, wi));
        if value == 0.0 || pdf == 0.0 {
            [0.0; N]
        } else {
            harmonics::<N>(wi).map(|y| y * y * value * value / pdf)
        }
    });
    let variance = std::array::from_fn(|i| (squares[i] - blur - exact[i] * exact[i]).max(0.0));
    let carried = |stream: &mut Stream| match draw(scatterer, wo, stream).filter(|sample| !sample.delta) {
        Some(sample) => harmonics::<N>(sample.wi).map(|y| y * sample.weight),
        None => [0.0; N],
    };
    let mut stream = pilot(seeds);
    let others = Covariance::of((0..samples.max(OTHERS)).map(|_| carried(&mut stream)));
    let expected = Expected { mean: exact, error, variance, others: Some(others) };
    let judge = |&seed: &u64| {
        // The samples are drawn twice: the second pass depends on the results of the first.
        let again = || {
            let mut stream = Stream::new(seed);
            (0..samples).map(move |_| carried(&mut stream))
        };
        let light = exact.iter().any(|moment| moment.abs() > error);
        conclude(&hotelling(again, &expected), light, samples, level)
    };
    seeds.iter().map(judge).collect()
}

/// The verdict on the components; `light` tells whether the value is nonzero anywhere.
fn conclude(found: &Components, light: bool, samples: usize, level: f64) -> Outcome {
    let Components { used, rank, p_value, statistic } = *found;
    if rank == 0 && !p_value.is_nan() {
        return if light {
            Outcome::new("moments", Verdict::Inconclusive, "no sample met the light outside delta lobes")
        } else {
            Outcome::new("moments", Verdict::Equivalent, "no light outside delta lobes")
        };
    }
    let detectable = detectable_chi_square(samples as f64, used.max(1) as f64, level);
    let verdict = match judge(p_value, level, detectable, MARGIN) {
        Verdict::Equivalent if used == 0 => Verdict::Inconclusive,
        verdict => verdict,
    };
    let message = format!(
        "T² = {statistic:.1} for {used} components, p = {p_value:.3e}; {} of {rank} are too heavy-tailed or too fine to \
         use; would find a shift of {detectable:.4} standard deviations",
        rank - used,
    );
    let outcome = Outcome::new("moments", verdict, message)
        .detectable(detectable)
        .figure("statistic", statistic)
        .figure("components", used as f64)
        .figure("left_out", (rank - used) as f64);
    if used > 0 || p_value.is_nan() { outcome.p_value(p_value) } else { outcome }
}
