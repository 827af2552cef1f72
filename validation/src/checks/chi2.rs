//! Do sampled directions follow the density? Pearson's χ² test.
//!
//! Finds a wrong shape *and* a wrong total of the density, since draws without a direction (absorption, delta
//! lobes) form one more bin, whose expected share is 1 − ∫pdf. Cannot detect a wrong weight: see `weight` and
//! `furnace`.
//!
//! Expected counts come from adaptive quadrature. Its errors, as the non-centrality Σ n e²/p they could
//! cause, must be negligible beside the statistic's own standard deviation √(2k); otherwise the verdict is
//! inconclusive.

use super::{BLURRED, Check, Effort, always, draw, judge, partition::Partition, pilot, show};
use crate::{
    quadrature::Integral,
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{Stream, Verdict, distributions::chi_square_upper, power::detectable_chi_square},
};

pub(super) const CHECK: Check = Check {
    name: "chi2",
    about: "sampled directions follow the pdf (Pearson's χ² test)",
    applies: always,
    outcomes,
};

/// The root mean square relative error of the density that must be detectable.
const MARGIN: f64 = 0.05;

/// Bins with an expected count below this are pooled (Cochran 1954).
const POOL: f64 = 5.0;

/// Expected number of samples per bin, which determines the number of bins.
const PER_BIN: usize = 1024;
/// Bounds on the number of bins.
const BINS: [usize; 2] = [16, 512];

/// Largest error of all expected counts together, in samples: small beside the noise of even the smallest
/// bin.
const QUADRATURE: f64 = 2.0;

fn outcomes(scatterer: &dyn Scatterer, wo: DVec3, seeds: &[u64], effort: &Effort) -> Vec<Outcome> {
    let bins = (effort.samples / PER_BIN).clamp(BINS[0], BINS[1]);
    let partition = Partition::adapt(scatterer, wo, &mut pilot(seeds), bins);
    let integrals =
        partition.integrate(QUADRATURE / effort.samples as f64, scatterer, |wi| scatterer.pdf(wo, wi));
    let judge = |&seed: &u64| match count(scatterer, wo, seed, effort, &partition) {
        Ok(observed) => conclude(&observed, &integrals, |bin| partition.place(bin), effort),
        Err((wi, pdf)) => {
            let message = format!("sampled {}, where the pdf is {pdf}", show(wi));
            Outcome::new("chi2", Verdict::Different, message).p_value(0.0)
        }
    };
    seeds.iter().map(judge).collect()
}

/// Counts of samples in each bin and, last, of those without a direction; or a sampled direction whose
/// density is invalid, with that density.
fn count(
    scatterer: &dyn Scatterer,
    wo: DVec3,
    seed: u64,
    effort: &Effort,
    partition: &Partition,
) -> Result<Vec<f64>, (DVec3, f64)> {
    let mut observed = vec![0.0; partition.bins() + 1];
    let mut stream = Stream::new(seed);
    for _ in 0..effort.samples {
        let bin = match draw(scatterer, wo, &mut stream).filter(|sample| !sample.delta) {
            None => partition.bins(),
            Some(sample) => {
                let pdf = scatterer.pdf(wo, sample.wi);
                if pdf.is_nan() || pdf <= 0.0 || pdf.is_infinite() {
                    return Err((sample.wi, pdf));
                }
                partition.locate(sample.wi)
            }
        };
        observed[bin] += 1.0;
    }
    Ok(observed)
}

fn conclude(
    observed: &[f64],
    integrals: &[Integral],
    place: impl Fn(usize) -> String,
    effort: &Effort,
) -> Outcome {
    let samples = effort.samples as f64;
    let total: Integral = integrals.iter().copied().sum();
    if !total.value.is_finite() {
        return Outcome::new("chi2", Verdict::Different, "the pdf is not finite").p_value(0.0);
    }
    let rest = Integral { value: (1.0 - total.value).max(0.0), error: total.error };
    let cells = integrals.iter().chain([&rest]).zip(observed).map(|(integral, &count)| Bin {
        observed: count,
        expected: samples * integral.value,
        error: samples * integral.error,
    });
    let cells: Vec<Bin> = cells.collect();
    let bins = pool(cells.clone());
    let statistic: f64 = bins.iter().map(|bin| square(bin.observed - bin.expected) / bin.expected).sum();
    let noncentrality: f64 = bins.iter().map(|bin| square(bin.error) / bin.expected).sum();
    let degrees = bins.len().saturating_sub(1) as f64;
    if degrees == 0.0 {
        let drawn: f64 = observed[..integrals.len()].iter().sum();
        return if total.value <= total.error && drawn == 0.0 {
            Outcome::new("chi2", Verdict::Equivalent, "no density and no sample outside delta lobes")
        } else {
            Outcome::new("chi2", Verdict::Inconclusive, "too little of the density to fill two bins")
        };
    }
    let p_value = chi_square_upper(statistic, degrees);
    let detectable = detectable_chi_square(samples, degrees, effort.level);
    let blurred = noncentrality > 0.1 * (2.0 * degrees).sqrt();
    let verdict =
        if blurred { Verdict::Inconclusive } else { judge(p_value, effort.level, detectable, MARGIN) };
    let more = match verdict {
        Verdict::Different => format!("; most of it {}", worst(&cells, place)),
        _ if blurred => "; the pdf could not be integrated well enough".into(),
        _ => String::new(),
    };
    let message = format!(
        "χ² = {statistic:.1} with {degrees} degrees of freedom, p = {p_value:.3e}; \
         would find an RMS error of the bins of {:.2} %{more}",
        100.0 * detectable
    );
    let outcome = Outcome::new("chi2", verdict, message)
        .detectable(detectable)
        .figure("statistic", statistic)
        .figure("degrees", degrees)
        .figure("quadrature_noncentrality", noncentrality);
    if noncentrality <= BLURRED * (2.0 * degrees).sqrt() { outcome.p_value(p_value) } else { outcome }
}

#[derive(Clone, Copy)]
struct Bin {
    observed: f64,
    expected: f64,
    error: f64,
}

impl Bin {
    fn add(&mut self, other: Self) {
        self.observed += other.observed;
        self.expected += other.expected;
        self.error += other.error;
    }
}

/// The bin that adds most to the statistic, in words. The last is that of draws without a direction.
fn worst(bins: &[Bin], place: impl Fn(usize) -> String) -> String {
    let share = |bin: &Bin| square(bin.observed - bin.expected) / bin.expected.max(POOL);
    let found = bins.iter().enumerate().max_by(|(_, a), (_, b)| share(a).total_cmp(&share(b)));
    let Some((index, bin)) = found else { return "nowhere".into() };
    let place = if index + 1 == bins.len() { "in draws without a direction".into() } else { place(index) };
    format!("{place}, with {} draws where the pdf has {:.1}", bin.observed, bin.expected)
}

/// Merges bins from the smallest up until each expects at least [`POOL`] samples; a remainder joins the last.
fn pool(mut bins: Vec<Bin>) -> Vec<Bin> {
    bins.sort_by(|a, b| a.expected.total_cmp(&b.expected));
    let mut pooled: Vec<Bin> = Vec::new();
    for bin in bins {
        match pooled.last_mut().filter(|last| last.expected < POOL) {
            Some(last) => last.add(bin),
            None => pooled.push(bin),
        }
    }
    if let Some(remainder) = pooled.pop_if(|last| last.expected < POOL) {
        match pooled.last_mut() {
            Some(last) => last.add(remainder),
            None => pooled.push(remainder),
        }
    }
    pooled
}

fn square(value: f64) -> f64 {
    value * value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pooling_keeps_every_sample() {
        let bin = |observed, expected| Bin { observed, expected, error: 0.0 };
        let pooled = pool(vec![bin(9.0, 8.0), bin(0.0, 0.0), bin(1.0, 3.0), bin(2.0, 2.5), bin(7.0, 6.0)]);
        let counts: Vec<(f64, f64)> = pooled.iter().map(|bin| (bin.observed, bin.expected)).collect();
        assert_eq!(counts, [(3.0, 5.5), (7.0, 6.0), (9.0, 8.0)]);
        let pooled = pool(vec![bin(1.0, 3.0), bin(2.0, 3.5), bin(4.0, 4.0)]);
        assert_eq!((pooled.len(), pooled[0].observed, pooled[0].expected), (1, 7.0, 10.5));
    }

    #[test]
    fn a_coarse_integral_is_no_verdict() {
        let integral = |error| Integral { value: 0.5, error };
        let effort = Effort { samples: 100_000, ..Effort::default() };
        let observed = [50_100.0, 49_900.0, 0.0];
        let nowhere = |_| String::new();
        assert_eq!(conclude(&observed, &[integral(1e-6); 2], nowhere, &effort).verdict, Verdict::Equivalent);
        assert_eq!(
            conclude(&observed, &[integral(1e-2); 2], nowhere, &effort).verdict,
            Verdict::Inconclusive
        );
    }

    #[test]
    fn a_difference_says_where_most_of_it_is() {
        let effort = Effort { samples: 100_000, ..Effort::default() };
        let halves = [Integral { value: 0.5, error: 1e-6 }; 2];
        let place = |bin| format!("bin {bin}");
        let message = |observed: &[f64]| conclude(observed, &halves, place, &effort).message;
        let wrong = message(&[53_000.0, 47_000.0, 0.0]);
        assert!(wrong.contains("most of it bin") && wrong.contains("where the pdf has 50000.0"), "{wrong}");
        let lost = message(&[45_000.0, 45_000.0, 10_000.0]);
        assert!(lost.contains("in draws without a direction, with 10000 draws"), "{lost}");
        assert!(!message(&[50_100.0, 49_900.0, 0.0]).contains("most of it"));
    }
}
