//! Is the distribution reciprocal?
//!
//! f(wo, wi) / η(wo)² = f(wi, wo) / η(wi)² (Veach 1997, eq. 5.14), for individual pairs of directions, both
//! sampled from the model and uniform over the sphere.
//!
//! A delta lobe has the coefficient c = weight · pdf. Crossing, it is c = T (η(wo)/η(wi))², T being the same both
//! ways, so there c η(wi)⁴ must be that of the way back times η(wo)⁴. Blind to lobes too rare to be drawn.

use std::f64::consts::{PI, TAU};

use super::{Check, Effort, delta::Lobes, draw, has_no_digits, relative_difference, show};
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
        if one_way == 0.0 && other_way == 0.0 {
            continue;
        }
        // Finite, but without significant digits to compare.
        if worst_of(one_way, other_way) < effort.smallest {
            silent = false;
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
    let lobes = delta_lobes(scatterer, &laws, wo, effort, &mut stream);
    for Pair { wi, error, blurred: is_blurred } in &lobes.pairs {
        checked += 1;
        if *is_blurred {
            blurred += 1;
            continue;
        }
        wrong += usize::from(error.is_nan() || *error > effort.tolerance);
        if error.is_nan() || *error > largest {
            (largest, place) = (*error, *wi);
        }
    }
    let verdict = match (wrong, checked) {
        // A way back that was never drawn may be rare, or missing.
        (0, _) if lobes.lost > 0 => Verdict::Inconclusive,
        // There is light, but never enough to compare.
        (0, 0) if !silent => Verdict::Inconclusive,
        // For example near a critical angle, where the Fresnel factor changes with every digit of a cosine.
        (0, _) if 100 * blurred > checked => Verdict::Inconclusive,
        (0, _) => Verdict::Equivalent,
        _ => Verdict::Different,
    };
    let message = if wrong == 0 && checked == 0 {
        if silent { "no light" } else { "no pair has digits to compare" }.to_string()
    } else if wrong == 0 && lobes.lost > 0 {
        format!("the way back was never drawn of {} delta lobes", lobes.lost)
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

/// A delta lobe and its way back.
struct Pair {
    wi: DVec3,
    /// Relative difference of the two coefficients.
    error: f64,
    /// Whether that may be because the coefficient changes within the rounding of its direction.
    blurred: bool,
}

struct Pairs {
    pairs: Vec<Pair>,
    /// Lobes whose way back was never drawn.
    lost: usize,
}

fn delta_lobes(
    scatterer: &dyn Scatterer,
    laws: &Laws,
    wo: DVec3,
    effort: &Effort,
    stream: &mut Stream,
) -> Pairs {
    let draws = effort.samples.div_ceil(16);
    let mut lobes_from = |from: DVec3| {
        let mut lobes = Lobes::default();
        lobes.draw(scatterer, from, draws, effort.tolerance, stream);
        lobes
    };
    // That of all lobes that lead into a direction; `None` if none was drawn.
    let coefficient = |lobes: &Lobes, to: DVec3| {
        // Directions are bent, so what was rounded once is not where it was.
        let near = |wi: DVec3| (wi - to).length() <= 1e3 * effort.tolerance;
        let leading = lobes.list.iter().filter(|lobe| near(lobe.of.wi));
        let sum: f64 = leading.map(|lobe| lobe.of.weight * lobe.of.pdf).sum();
        (sum > 0.0).then_some(sum * laws.index(to).powi(4))
    };
    let outward = lobes_from(wo);
    let (mut pairs, mut lost) = (vec![], 0);
    for lobe in &outward.list {
        let wi = lobe.of.wi;
        match (coefficient(&outward, wi), coefficient(&lobes_from(wi), wo)) {
            (Some(one_way), Some(other_way)) => {
                let error = relative_difference(one_way, other_way);
                let mut changes = || {
                    let nudged = (wi + 4.0 * f64::EPSILON * wi.any_orthonormal_vector()).normalize();
                    let change = |c| relative_difference(c, other_way);
                    coefficient(&lobes_from(nudged), wo).map_or(1.0, change) > 0.1 * effort.tolerance
                };
                let blurred = error > effort.tolerance && changes();
                pairs.push(Pair { wi, error, blurred });
            }
            _ => lost += 1,
        }
    }
    Pairs { pairs, lost }
}

/// f(wo, wi) / η(wo)².
fn reduced(scatterer: &dyn Scatterer, laws: &Laws, wo: DVec3, wi: DVec3) -> f64 {
    let cosine = if scatterer.is_phase_function() { 1.0 } else { wi.z.abs() };
    let index = laws.index(wo);
    scatterer.value(wo, wi) / (cosine * index * index)
}
