//! The ratio of the efficiencies of two renderers.
//!
//! Efficiency is 1 / (error · seconds). The ratio is estimated in logarithms, paired by seed, since
//! interleaved renders share the state of the machine: dᵢ = mean over rungs of log(errorᵢ secondsᵢ) of B
//! minus that of A, and Student's interval of the mean of d. A percentile bootstrap of as few as eight values
//! would be too narrow.

use serde::Serialize;

use super::curve::{Interval, Rung};
use crate::statistics::distributions::{student_quantile, student_two_sided};
use crate::statistics::{Estimate, Welch};

/// Efficiency of A over that of B.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Ratio {
    /// The ratio with its 95 % interval; above 1 if A is more efficient.
    pub ratio: Interval,
    /// p-value of the hypothesis that both are equally efficient.
    pub p_value: f64,
    /// Whether the hypothesis is rejected at the level of 0.5 %.
    pub different: bool,
}

/// The level at which efficiencies are called different: half of the promised one per cent, so that an
/// experiment can confirm the promise.
const LEVEL: f64 = 0.005;

/// Compares ladders of the same sample counts and seeds. `None` if they do not match, if there are fewer than
/// three seeds, or if an error is not positive because the reference's noise exceeds it.
pub fn ratio(a: &[Rung], b: &[Rung]) -> Option<Ratio> {
    let count = a.first()?.errors.len();
    let whole = |r: &Rung| {
        r.errors.len() == count
            && r.seconds.len() == count
            && r.errors.iter().chain(&r.seconds).all(|v| *v > 0.0)
    };
    if count < 3 || a.len() != b.len() || !a.iter().chain(b).all(whole) {
        return None;
    }
    let cost = |rungs: &[Rung], i: usize| {
        rungs.iter().map(|r| libm::log(r.errors[i] * r.seconds[i])).sum::<f64>() / rungs.len() as f64
    };
    let estimate = Estimate::of((0..count).map(|i| cost(b, i) - cost(a, i)));
    let error = estimate.variance.sqrt();
    let p_value = if error > 0.0 {
        student_two_sided(estimate.mean / error, estimate.degrees)
    } else {
        f64::from(estimate.mean == 0.0)
    };
    let Interval { value, low, high } = student(&estimate);
    let [value, low, high] = [value, low, high].map(libm::exp);
    Some(Ratio { ratio: Interval { value, low, high }, p_value, different: p_value <= LEVEL })
}

/// The mean of independent values with Student's interval; `None` for fewer than two.
pub fn mean(values: &[f64]) -> Option<Interval> {
    (values.len() > 1).then(|| student(&Estimate::of(values.iter().copied())))
}

/// The ratio of the means of two groups of independent positive values, with Welch's interval of their
/// logarithms; `None` for fewer than two values of either, or one that is not positive.
pub fn ratio_of_means(a: &[f64], b: &[f64]) -> Option<Interval> {
    if a.len() < 2 || b.len() < 2 || !a.iter().chain(b).all(|v| *v > 0.0) {
        return None;
    }
    let [over, under] = [a, b].map(|values| Estimate::of(values.iter().map(|v| libm::log(*v))));
    let welch = Welch::new(under, over);
    let half = welch.half_width(0.05);
    let [value, low, high] = [0.0, -half, half].map(|by| libm::exp(welch.difference + by));
    Some(Interval { value, low, high })
}

fn student(estimate: &Estimate) -> Interval {
    let half = student_quantile(0.05, estimate.degrees) * estimate.variance.sqrt();
    Interval { value: estimate.mean, low: estimate.mean - half, high: estimate.mean + half }
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
                ladder.push(Rung { samples, errors, seconds });
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
                ratio(&a, &b).unwrap().different
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
            let ratio = ratio(&a, &b).unwrap().ratio;
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
        let rung = |error: f64| vec![Rung { samples: 1, errors: vec![error; 3], seconds: vec![1.0; 3] }];
        assert!(ratio(&rung(1.0), &rung(-0.1)).is_none() && ratio(&rung(1.0), &[]).is_none());
    }
}
