//! Which share of the light is scattered, and do sampling and evaluation agree on it?
//!
//! Three conditions: the mean sample weight outside delta lobes equals ∫ f |cos θ| dω by quadrature; the
//! albedo, delta lobes included, is at most 1, by the samples and by the integral with the samples of delta
//! lobes; and it is 1 if the model claims to be lossless, but below the surface of one that has no light
//! there at all and does not refract. Weights count as flux (η² taken out), to which energy conservation
//! applies. Blind to errors that value and sample share and that keep the albedo.

use super::{BLURRED, Check, Effort, always, draw, partition::Partition, pilot};
use crate::{
    quadrature::Integral,
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{
        Estimate, Interval, Stream, Verdict, Welch, hotelling::near_normal, power::detectable_difference,
    },
};

pub(super) const CHECK: Check = Check {
    name: "furnace",
    about: "sampled and integrated albedo agree, are at most 1, and 1 if lossless",
    applies: always,
    outcomes,
};

const BINS: usize = 64;

/// Tolerance of the integral, in units of 1/samples.
const QUADRATURE: f64 = 1.0;

fn outcomes(scatterer: &dyn Scatterer, wo: DVec3, seeds: &[u64], effort: &Effort) -> Vec<Outcome> {
    let laws = scatterer.laws();
    let partition = Partition::adapt(scatterer, wo, &mut pilot(seeds), BINS);
    let flux = |wi: DVec3| scatterer.value(wo, wi) * laws.flux_factor(wo, wi);
    let integral: Integral =
        partition.integrate(QUADRATURE / effort.samples as f64, scatterer, flux).into_iter().sum();
    seeds.iter().map(|&seed| judge(scatterer, wo, seed, effort, integral)).collect()
}

fn judge(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort, integral: Integral) -> Outcome {
    let laws = scatterer.laws();
    // The weight outside delta lobes, of these, and their sum.
    let weights = || {
        let mut stream = Stream::new(seed);
        (0..effort.samples).map(move |_| match draw(scatterer, wo, &mut stream) {
            None => [0.0; 3],
            Some(sample) => {
                let weight = sample.weight * laws.flux_factor(wo, sample.wi);
                if sample.delta { [0.0, weight, weight] } else { [weight, 0.0, weight] }
            }
        })
    };
    let [smooth, delta, total] = Estimate::of_each(weights());
    let exact = Estimate { mean: integral.value, variance: 0.0, degrees: f64::INFINITY };
    let welch = Welch::new(exact, smooth);
    // Possible error of quadrature and rounding, in units of albedo. The rounding is that of the albedo
    // itself.
    let blur = integral.error + effort.tolerance * integral.value.abs();
    // Draws that carry or lose about 1 may be so rare that none occurs in the sample of a correct model,
    // which its variance does not show. With confidence 1 − `level` their probability is below
    // −ln(level)/samples.
    let slack = blur - libm::log(effort.level) / effort.samples as f64;
    let agreement = Interval::around(welch.difference, welch.half_width(effort.level) + slack)
        .verdict(0.0, effort.albedo);
    let certain = Interval::around(total.mean, Welch::new(exact, total).half_width(effort.level) + slack);
    // What the integral says is exact where there are no delta lobes.
    let of_delta = Welch::new(exact, delta).half_width(effort.level);
    let rare = if delta.mean > 0.0 { slack } else { blur };
    let integrated = Interval::around(integral.value + delta.mean, of_delta + rare);
    let gains = |interval: &Interval| interval.low > 1.0 + effort.tolerance;
    let bounded =
        if gains(&certain) || gains(&integrated) { Verdict::Different } else { Verdict::Equivalent };
    let nothing = total.mean == 0.0 && integral.value == 0.0;
    let one_sided = wo.z < 0.0 && laws.eta.is_none() && nothing;
    let lossless = match (strict(certain, effort), strict(integrated, effort)) {
        _ if !laws.lossless || one_sided => Verdict::Equivalent,
        (Verdict::Different, _) | (_, Verdict::Different) => Verdict::Different,
        (sampled, integrated) => sampled.min(integrated),
    };
    let agreement = if within_noise(&welch, slack, effort.level) { agreement } else { Verdict::Different };
    let message = format!(
        "albedo {:.6} sampled, of which {:.6} ± {:.1e} outside delta lobes; {:.6} integrated{}{}",
        total.mean,
        smooth.mean,
        smooth.variance.sqrt(),
        integral.value,
        if bounded == Verdict::Different { "; more light leaves than arrives" } else { "" },
        if lossless == Verdict::Different { "; it claims to be lossless" } else { "" }
    );
    let outcome = Outcome::new("furnace", Verdict::all([agreement, bounded, lossless]), message)
        .detectable(detectable_difference(welch.standard_error, effort.level, welch.degrees) + slack)
        .figure("sampled", total.mean)
        .figure("sampled_smooth", smooth.mean)
        .figure("integrated", integral.value);
    // A constant weight leaves nothing to chance, and Student's distribution holds for means that are nearly
    // normal only.
    let by_chance = blur <= BLURRED * welch.standard_error;
    let normal = || nearly_normal(weights().map(|[smooth, ..]| smooth), &smooth, effort.samples as f64);
    if by_chance && normal() { outcome.p_value(welch.p_value()) } else { outcome }
}

/// Whether the mean of these weights is nearly normal.
fn nearly_normal(weights: impl Iterator<Item = f64>, mean: &Estimate, count: f64) -> bool {
    let deviation = (mean.variance * count).sqrt();
    let [third, fourth] = weights
        .map(|weight| (weight - mean.mean) / deviation)
        .fold([0.0; 2], |[a, b], z| [a + z * z * z, b + z * z * z * z]);
    near_normal(third / count, fourth / count - 3.0, count)
}

/// True if noise and slack explain the difference: a significant difference is a fault even if it is small.
fn within_noise(welch: &Welch, slack: f64, level: f64) -> bool {
    welch.difference.abs() <= welch.half_width(level) + slack
}

/// The verdict on a lossless model: its albedo may be 1, and the interval must be narrow enough to claim it.
fn strict(certain: Interval, effort: &Effort) -> Verdict {
    let widened = Interval { low: certain.low - effort.tolerance, high: certain.high + effort.tolerance };
    if widened.contains(1.0) { widened.verdict(1.0, effort.albedo) } else { Verdict::Different }
}
