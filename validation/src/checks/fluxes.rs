//! Flux moments, delta lobes included: a few averages by which two models can be compared.

use super::{Effort, draw};
use crate::{
    scatterer::{DVec3, Sample, Scatterer},
    statistics::{Estimate, Interval, Stream, Verdict, Welch},
};

/// The moments' weighting functions ψ of a direction: 1, whether it points upward, and its coordinates.
const NAMES: [&str; 5] = ["albedo", "upward share", "x", "y", "z"];

/// The flux moments weight · (η(ωi)/η(ωo))² · ψ(ωi) of an endless sequence of draws.
fn fluxes(scatterer: &dyn Scatterer, wo: DVec3, seed: u64) -> impl Iterator<Item = [f64; 5]> {
    let laws = scatterer.laws();
    let mut stream = Stream::new(seed);
    let flux = move |sample: Sample| {
        let (flux, wi) = (sample.weight * laws.flux_factor(wo, sample.wi), sample.wi);
        [1.0, f64::from(wi.z > 0.0), wi.x, wi.y, wi.z].map(|ψ| flux * ψ)
    };
    std::iter::repeat_with(move || draw(scatterer, wo, &mut stream).map_or([0.0; 5], flux))
}

/// Whether the means of all moments of two models lie within `margin` of one another at the confidence level,
/// and a sentence about the worst.
///
/// Draws with the same random numbers are compared in pairs: similar models differ with little variance, and
/// a model that ignores the changed parameter does not differ at all.
pub(super) fn compare(
    models: [&dyn Scatterer; 2],
    wo: DVec3,
    seed: u64,
    margin: f64,
    effort: &Effort,
) -> (Verdict, String) {
    let level = crate::statistics::sidak(effort.level, NAMES.len());
    let [a, b] = models.map(|model| fluxes(model, wo, seed));
    let pairs = a.zip(b).take(effort.samples);
    // The moments of a, then the paired differences b − a.
    let moments =
        Estimate::of_each(pairs.map(|(a, b)| {
            std::array::from_fn::<_, 10, _>(|i| if i < 5 { a[i] } else { b[i - 5] - a[i - 5] })
        }));
    let (means, differences) = moments.split_at(NAMES.len());
    let nothing = Estimate { mean: 0.0, variance: 0.0, degrees: f64::INFINITY };
    let answer = |i: usize| {
        let half_width = Welch::new(nothing, differences[i]).half_width(level) + effort.tolerance;
        let interval = Interval::around(differences[i].mean, half_width);
        // A difference that may lie within the margin is no failure: such an interval needs more samples.
        let verdict = match interval.verdict(0.0, margin) {
            Verdict::Different if interval.meets(0.0, margin) => Verdict::Inconclusive,
            verdict => verdict,
        };
        (verdict, interval.high.max(-interval.low))
    };
    let answers: [(Verdict, f64); 5] = std::array::from_fn(answer);
    let order =
        |&i: &usize, &j: &usize| answers[i].0.cmp(&answers[j].0).then(answers[i].1.total_cmp(&answers[j].1));
    let worst = (0..NAMES.len()).max_by(order).unwrap_or(0);
    let message = format!(
        "{} is {:.6} against {:.6}: no more than {:.1e} apart, at a margin of {margin:.1e}",
        NAMES[worst],
        means[worst].mean,
        means[worst].mean + differences[worst].mean,
        answers[worst].1
    );
    (answers[worst].0, message)
}
