//! The ratio of the efficiencies of two renderers.
//!
//! Efficiency is 1 / (error · seconds). The ratio is estimated in logarithms, paired by seed, since
//! interleaved renders share the state of the machine: dᵢ = mean over rungs of log(errorᵢ secondsᵢ) of B
//! minus that of A, and Student's interval of the mean of d. A percentile bootstrap of as few as eight values
//! would be too narrow.
//!
//! The noise of a reference is in all errors against it, and not in the scatter of d. With R pictures, and cⱼ the mean
//! of log(error) over seeds and rungs against the mean of all but picture j, the jackknife's variance of that mean is
//! (R − 1)/R Σ (cⱼ − c̄)², and has R − 1 degrees of freedom (Efron and Stein 1981). It is added to that of d, with
//! the degrees of freedom of Welch and Satterthwaite.

use serde::Serialize;

use super::curve::{Measured, Rung};
use crate::statistics::distributions::{student_quantile, student_two_sided};
use crate::statistics::{Estimate, Welch};

/// Efficiency of A over that of B.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Ratio {
    /// The ratio with its 95 % interval; above 1 if A is more efficient.
    pub ratio: Measured,
    /// p-value of the hypothesis that both are equally efficient.
    pub p_value: f64,
    /// Whether the hypothesis is rejected at the level of 0.5 %.
    pub different: bool,
}

/// The level at which efficiencies are called different: half of the promised one per cent, so that an
/// experiment can confirm the promise.
const LEVEL: f64 = 0.005;

/// Compares ladders of the same sample counts and seeds. `same_reference` is whether the errors of both are against
/// the same pictures. `None` if the ladders do not match, if there are fewer than three seeds, or if an error is not
/// positive because the reference's noise exceeds it.
pub fn ratio(a: &[Rung], b: &[Rung], same_reference: bool) -> Option<Ratio> {
    let count = a.first()?.errors.len();
    let whole = |r: &Rung| {
        r.errors.len() == count
            && r.seconds.len() == count
            && r.errors.iter().chain(&r.seconds).chain(r.without.iter().flatten()).all(|v| *v > 0.0)
    };
    if count < 3 || a.len() != b.len() || !a.iter().chain(b).all(whole) {
        return None;
    }
    let cost = |rungs: &[Rung], i: usize| {
        rungs.iter().map(|r| libm::log(r.errors[i] * r.seconds[i])).sum::<f64>() / rungs.len() as f64
    };
    let estimate = Estimate::of((0..count).map(|i| cost(b, i) - cost(a, i)));
    let [of_a, of_b] = [a, b].map(against_fewer);
    let estimate = if same_reference {
        let difference: Vec<f64> = of_a.iter().zip(&of_b).map(|(a, b)| b - a).collect();
        beside(estimate, &difference)
    } else {
        beside(beside(estimate, &of_a), &of_b)
    };
    let error = estimate.variance.sqrt();
    let p_value = if error > 0.0 {
        student_two_sided(estimate.mean / error, estimate.degrees)
    } else {
        f64::from(estimate.mean == 0.0)
    };
    let Measured { value, low, high } = student(&estimate);
    let [value, low, high] = [value, low, high].map(libm::exp);
    Some(Ratio { ratio: Measured { value, low, high }, p_value, different: p_value <= LEVEL })
}

/// The mean of log(error) over seeds and rungs against each reference that lacks a picture.
fn against_fewer(rungs: &[Rung]) -> Vec<f64> {
    let pictures = rungs.iter().map(|rung| rung.without.len()).min().unwrap_or(0);
    let mean = |picture: usize| {
        let errors = || rungs.iter().flat_map(|rung| &rung.without[picture]);
        errors().map(|error| libm::log(*error)).sum::<f64>() / errors().count() as f64
    };
    (0..pictures).map(mean).collect()
}

/// The estimate with the jackknife's variance of these values besides its own.
fn beside(estimate: Estimate, values: &[f64]) -> Estimate {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let more = (count - 1.0) / count * values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
    // Of no values, or of one.
    if more.is_nan() || more <= 0.0 {
        return estimate;
    }
    let part = |variance: f64, degrees: f64| variance * variance / degrees;
    let variance = estimate.variance + more;
    let degrees = variance * variance / (part(estimate.variance, estimate.degrees) + part(more, count - 1.0));
    Estimate { variance, degrees, ..estimate }
}

/// The mean of a rung's errors, or of what else was measured against the reference, with Student's interval, in
/// which the reference's noise is counted; `None` for fewer than two.
pub fn mean(rung: &Rung) -> Option<Measured> {
    let average = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let against_fewer: Vec<f64> = rung.without.iter().map(average).collect();
    let estimate = Estimate::of(rung.errors.iter().copied());
    (rung.errors.len() > 1).then(|| student(&beside(estimate, &against_fewer)))
}

/// The ratio of the means of two groups of independent positive values, with Welch's interval of their
/// logarithms; `None` for fewer than two values of either, or one that is not positive.
pub fn ratio_of_means(a: &[f64], b: &[f64]) -> Option<Measured> {
    if a.len() < 2 || b.len() < 2 || !a.iter().chain(b).all(|v| *v > 0.0) {
        return None;
    }
    let [over, under] = [a, b].map(|values| Estimate::of(values.iter().map(|v| libm::log(*v))));
    let welch = Welch::new(under, over);
    let half = welch.half_width(0.05);
    let [value, low, high] = [0.0, -half, half].map(|by| libm::exp(welch.difference + by));
    Some(Measured { value, low, high })
}

fn student(estimate: &Estimate) -> Measured {
    let half = student_quantile(0.05, estimate.degrees) * estimate.variance.sqrt();
    Measured { value: estimate.mean, low: estimate.mean - half, high: estimate.mean + half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Stream;

    /// A synthetic renderer: the error of a picture of many pixels scatters by 2 %, and the time by 2 %
    /// around a common drift.
    fn pair(stream: &mut Stream, seeds: usize, faster: f64) -> [Vec<Rung>; 2] {
        let mut ladders = [vec![], vec![]];
        for samples in [16u32, 64, 256] {
            let n = f64::from(samples);
            let drift: Vec<f64> = (0..seeds).map(|_| libm::exp(0.1 * stream.normal())).collect();
            for (which, ladder) in ladders.iter_mut().enumerate() {
                let speed = if which == 0 { faster } else { 1.0 };
                let mut scatter = |value: f64| value * libm::exp(0.02 * stream.normal());
                let errors = (0..seeds).map(|_| scatter(1.0 / n)).collect();
                let seconds = drift.iter().map(|d| scatter(d * n / speed)).collect();
                ladder.push(Rung { samples, errors, seconds, without: vec![] });
            }
        }
        ladders
    }

    #[test]
    fn five_per_cent_are_found_and_none_are_not() {
        let mut stream = Stream::named("synthetic renderers", 0);
        let called = |stream: &mut Stream, faster: f64| {
            let trials = (0..2000).filter(|_| {
                let [a, b] = pair(stream, 8, faster);
                ratio(&a, &b, false).unwrap().different
            });
            trials.count() as f64 / 2000.0
        };
        let found = called(&mut stream, 1.05);
        assert!(found >= 0.9, "found {found}");
        // The level of 0.5 %, and three standard errors of it in 2000 trials: 0.47 %.
        let false_alarms = called(&mut stream, 1.0);
        assert!(false_alarms <= 0.0097, "false alarms {false_alarms}");
    }

    #[test]
    fn the_interval_covers_the_truth() {
        let mut stream = Stream::named("coverage", 0);
        let covered = (0..2000).filter(|_| {
            let [a, b] = pair(&mut stream, 8, 1.3);
            let ratio = ratio(&a, &b, false).unwrap().ratio;
            ratio.low <= 1.3 && 1.3 <= ratio.high
        });
        let share = covered.count() as f64 / 2000.0;
        assert!((share - 0.95).abs() < 0.015, "{share}");
    }

    #[test]
    fn ratios_of_means_cover_the_truth() {
        let mut stream = Stream::named("ratios of means", 0);
        let covered = (0..2000).filter(|_| {
            let mut four = |mean: f64, scatter: f64| {
                (0..4).map(|_| mean * (1.0 + scatter * stream.normal())).collect::<Vec<_>>()
            };
            let found = ratio_of_means(&four(3.0, 0.02), &four(2.0, 0.01)).unwrap();
            found.low <= 1.5 && 1.5 <= found.high
        });
        let share = covered.count() as f64 / 2000.0;
        assert!((share - 0.95).abs() < 0.015, "{share}");
        assert!(ratio_of_means(&[1.0], &[1.0, 2.0]).is_none());
        assert!(ratio_of_means(&[1.0, 0.0], &[1.0, 2.0]).is_none());
    }

    #[test]
    fn swallowed_errors_are_no_answer() {
        let rung = |error: f64| {
            vec![Rung { samples: 1, errors: vec![error; 3], seconds: vec![1.0; 3], ..Rung::default() }]
        };
        assert!(ratio(&rung(1.0), &rung(-0.1), false).is_none() && ratio(&rung(1.0), &[], false).is_none());
        let fewer = rung(1.0).into_iter().map(|rung| Rung { without: vec![vec![0.0; 3]; 4], ..rung });
        assert!(ratio(&rung(1.0), &fewer.collect::<Vec<_>>(), false).is_none());
    }

    /// Equal renderers whose references, of four pictures each, change all errors by about what the scatter of the
    /// seeds makes of their mean.
    #[test]
    fn noise_of_references_is_no_difference() {
        const SCATTER: f64 = 0.01;
        let mut stream = Stream::named("references", 0);
        let mut called = [0, 0, 0];
        for _ in 0..2000 {
            let mut pictures = || [(); 4].map(|()| 2.0 * SCATTER * stream.normal());
            let references = [pictures(), pictures()];
            let mut ladder = |reference: [f64; 4]| {
                let all = reference.iter().sum::<f64>();
                let errors: Vec<f64> = (0..8).map(|_| 0.02 * stream.normal()).collect();
                let against = |noise: f64| errors.iter().map(|e| libm::exp(e + noise)).collect::<Vec<f64>>();
                let without = reference.iter().map(|left| against((all - left) / 3.0)).collect();
                vec![Rung { samples: 1, errors: against(all / 4.0), seconds: vec![1.0; 8], without }]
            };
            let [a, b] = references.map(&mut ladder);
            let unaware = |rungs: &[Rung]| {
                let rung = |rung: &Rung| Rung { without: vec![], ..rung.clone() };
                rungs.iter().map(rung).collect::<Vec<_>>()
            };
            called[0] += i32::from(ratio(&a, &b, false).unwrap().different);
            called[1] += i32::from(ratio(&unaware(&a), &unaware(&b), false).unwrap().different);
            // With one reference for both its noise is theirs alike.
            let c = ladder(references[0]);
            called[2] += i32::from(ratio(&a, &c, true).unwrap().different);
        }
        // The level of 0.5 %, and three standard errors of it in 2000 trials: 0.47 %.
        assert!(called[0] <= 19 && called[2] <= 19 && called[1] > 60, "{called:?}");
    }
}
