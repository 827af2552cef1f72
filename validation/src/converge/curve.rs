//! Replicates over a ladder of sample counts: error, time, their product, and slope, with bootstrap
//! intervals, or Student's by the jackknife where seeds are few.
//!
//! Part of the time may not depend on the number of samples n, such as that of planning, or of starting where a
//! renderer does not tell: t(n) = f + c n. A power law in t would bend, so it is fitted in c n, which is to say in
//! n; f counts where times to an error are told.
//!
//! Both (Efron 1979, expanded percentile intervals; Tukey 1958) draw or leave out whole seeds: the rungs of a
//! seed are rendered one after the other and share the state of the machine.

use serde::Serialize;

use crate::statistics::distributions::{normal_two_sided, student_quantile};
use crate::statistics::{Estimate, Stream};

/// Number of resamplings; the 2.5 % and 97.5 % quantiles of that many are known to about half a per cent of
/// level.
pub const RESAMPLINGS: usize = 2000;

/// Least number of seeds for bootstrap intervals: with fewer, the required percentiles lie beyond all
/// resamplings.
const ENOUGH: usize = 8;

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// One sample count, with the error and the seconds of each seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Rung {
    pub samples: u32,
    pub errors: Vec<f64>,
    pub seconds: Vec<f64>,
    /// For each picture of the reference the errors against the mean of its others; empty if they are not known.
    pub without: Vec<Vec<f64>>,
}

/// The results of a ladder of sample counts.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// Mean error of each rung.
    pub errors: Vec<Measured>,
    /// Mean seconds of each rung.
    pub seconds: Vec<Measured>,
    /// Geometric mean over rungs of 1 / (error · seconds): larger is better.
    pub efficiency: Measured,
    /// d log error / d log n by least squares; −1 for independent samples. That is the slope against seconds, but
    /// for those that do not depend on n.
    pub slope: Option<Measured>,
    /// Seconds to reach each error of [`TARGETS`], from the line fitted for the slope and from t(n).
    pub seconds_to: Vec<Option<Measured>>,
}

/// The errors for which times are estimated.
pub const TARGETS: [f64; 2] = [1e-2, 1e-3];

/// Logarithm of the efficiency of resampled seeds: −mean over rungs of log(mean error · mean seconds). NaN
/// where an error is not positive.
fn log_efficiency(rungs: &[Rung], seeds: &[usize]) -> f64 {
    let product = |r: &Rung| libm::log(mean(&r.errors, seeds) * mean(&r.seconds, seeds));
    -rungs.iter().map(product).sum::<f64>() / rungs.len() as f64
}

/// The curve of rungs that all have the same seeds. `None` without rungs, or with fewer than two seeds.
pub fn curve(rungs: &[Rung], seed: u64) -> Option<Curve> {
    let count = rungs.first()?.errors.len();
    if count < 2 || rungs.iter().any(|r| r.errors.len() != count || r.seconds.len() != count) {
        return None;
    }
    let draws = resamplings(count, seed);
    let each = |statistic: &dyn Fn(&[usize]) -> f64| interval(statistic, Sign::Positive, count, &draws);
    let several = rungs.len() > 1;
    let time_to = |goal: f64, seeds: &[usize]| time(rungs, seeds).at(line(rungs, seeds).samples_to(goal));
    // An error that does not fall with the number of samples reaches no goal.
    let target =
        |goal: f64| several.then(|| each(&|s| time_to(goal, s))).filter(|seconds| seconds.value.is_finite());
    let slope = || interval(|s| line(rungs, s).slope, Sign::Any, count, &draws);
    Some(Curve {
        errors: rungs.iter().map(|r| each(&|s| mean(&r.errors, s))).collect(),
        seconds: rungs.iter().map(|r| each(&|s| mean(&r.seconds, s))).collect(),
        efficiency: each(&|s| libm::exp(log_efficiency(rungs, s))),
        slope: several.then(slope),
        seconds_to: TARGETS.iter().map(|goal| target(*goal)).collect(),
    })
}

/// [`RESAMPLINGS`] draws of `count` seeds with replacement.
fn resamplings(count: usize, seed: u64) -> Vec<Vec<usize>> {
    let mut stream = Stream::new(seed);
    let mut one = || (0..count).map(|_| (stream.uniform() * count as f64) as usize).collect();
    (0..RESAMPLINGS).map(|_| one()).collect()
}

/// Which values a statistic can have.
#[derive(Clone, Copy, PartialEq)]
enum Sign {
    Positive,
    Any,
}

/// A statistic of all seeds, with the expanded percentile interval of its resamplings.
fn interval(statistic: impl Fn(&[usize]) -> f64, sign: Sign, count: usize, draws: &[Vec<usize>]) -> Measured {
    let all: Vec<usize> = (0..count).collect();
    if count < ENOUGH {
        return jackknife(statistic, sign, &all);
    }
    let mut values: Vec<f64> = draws.iter().map(|draw| statistic(draw)).collect();
    values.sort_by(f64::total_cmp);
    // The bootstrap distribution of n seeds is narrower than that of the statistic by the factor √((n −
    // 1)/n), and lacks Student's tails: wider percentiles correct both (Hesterberg 2015, "What teachers
    // should know about the bootstrap", §5.2).
    let number = count as f64;
    let reach = student_quantile(0.05, number - 1.0) * (number / (number - 1.0)).sqrt();
    let tail = 0.5 * normal_two_sided(reach);
    let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
    Measured { value: statistic(&all), low: at(tail), high: at(1.0 - tail) }
}

/// A statistic of all seeds with Student's interval. Its standard error is (n − 1)/√n times the standard
/// deviation of the statistic with one seed left out. Positive statistics are transformed to logarithms, so
/// that their intervals are positive.
fn jackknife(statistic: impl Fn(&[usize]) -> f64, sign: Sign, all: &[usize]) -> Measured {
    let others = |i: &usize| all.iter().copied().filter(|other| other != i).collect::<Vec<_>>();
    let mut without: Vec<f64> = all.iter().map(|i| statistic(&others(i))).collect();
    let value = statistic(all);
    // An error from which more noise of the reference is subtracted than there is may be negative.
    let positive = sign == Sign::Positive && value > 0.0 && without.iter().all(|v| *v > 0.0);
    if positive {
        without.iter_mut().for_each(|v| *v = libm::log(*v));
    }
    let degrees = all.len() as f64 - 1.0;
    let known = without.iter().all(|v| v.is_finite());
    let deviation = if known { Estimate::of(without).variance.sqrt() } else { f64::INFINITY };
    let half = student_quantile(0.05, degrees) * degrees * deviation;
    match positive {
        true => Measured { value, low: value * libm::exp(-half), high: value * libm::exp(half) },
        false => Measured { value, low: value - half, high: value + half },
    }
}

fn mean(values: &[f64], seeds: &[usize]) -> f64 {
    seeds.iter().map(|&s| values[s]).sum::<f64>() / seeds.len() as f64
}

/// Seconds as a function of the number of samples.
struct Time {
    fixed: f64,
    of_sample: f64,
}

impl Time {
    fn at(&self, samples: f64) -> f64 {
        self.fixed + self.of_sample * samples
    }
}

/// t(n) by least squares of relative deviations; without a fixed part if that would be negative, which is noise.
fn time(rungs: &[Rung], seeds: &[usize]) -> Time {
    // Of f/t + c n/t = 1.
    let (mut ff, mut fc, mut cc, mut f, mut c) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for rung in rungs {
        let one = 1.0 / mean(&rung.seconds, seeds);
        let samples = f64::from(rung.samples) * one;
        (ff, fc, cc) = (ff + one * one, fc + one * samples, cc + samples * samples);
        (f, c) = (f + one, c + samples);
    }
    let determinant = ff * cc - fc * fc;
    let fixed = (cc * f - fc * c) / determinant;
    let of_sample = (ff * c - fc * f) / determinant;
    // Where time does not depend on samples all of it is fixed.
    match (fixed > 0.0, of_sample > 0.0) {
        (true, true) => Time { fixed, of_sample },
        (true, false) => Time { fixed: f / ff, of_sample: 0.0 },
        _ => Time { fixed: 0.0, of_sample: c / cc },
    }
}

/// log error = height + slope · log samples.
struct Line {
    height: f64,
    slope: f64,
}

impl Line {
    /// How many samples reach an error; infinitely many where it does not fall with their number.
    fn samples_to(&self, error: f64) -> f64 {
        if self.slope >= 0.0 {
            return f64::INFINITY;
        }
        libm::exp((libm::log(error) - self.height) / self.slope)
    }
}

fn line(rungs: &[Rung], seeds: &[usize]) -> Line {
    let point = |r: &Rung| [libm::log(f64::from(r.samples)), libm::log(mean(&r.errors, seeds))];
    let points: Vec<[f64; 2]> = rungs.iter().map(point).collect();
    let count = points.len() as f64;
    let [x, y] = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count);
    let across: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    let along: f64 = points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum();
    let slope = across / along;
    Line { height: y - slope * x, slope }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_read_off() {
        let rung = |samples: u32| {
            let n = f64::from(samples);
            Rung { samples, errors: vec![0.4 / n; 3], seconds: vec![0.01 * n; 3], ..Rung::default() }
        };
        let found = curve(&[rung(4), rung(16), rung(64)], 0).unwrap();
        assert!((found.slope.unwrap().value + 1.0).abs() < 1e-12);
        assert!((found.efficiency.value - 250.0).abs() < 1e-9);
        assert!((found.seconds_to[0].unwrap().value - 0.4).abs() < 1e-9);
        assert!((found.seconds_to[1].unwrap().high - 4.0).abs() < 1e-9);
    }

    #[test]
    fn an_error_that_rises_reaches_no_goal() {
        let rung = |samples: u32, errors: [f64; 3]| Rung {
            samples,
            errors: errors.to_vec(),
            seconds: vec![0.01 * f64::from(samples); 3],
            ..Rung::default()
        };
        let rises = curve(&[rung(4, [0.02; 3]), rung(16, [0.006; 3]), rung(64, [0.5; 3])], 0).unwrap();
        assert!(rises.slope.unwrap().value > 0.0 && rises.seconds_to.iter().all(Option::is_none));
        // Without the first seed it does not fall.
        let may = curve(&[rung(4, [0.2, 0.1, 0.1]), rung(64, [0.01, 0.1, 0.1])], 0).unwrap();
        let seconds = may.seconds_to[0].unwrap();
        assert!(seconds.value.is_finite() && seconds.high == f64::INFINITY, "{seconds:?}");
    }

    #[test]
    fn a_fixed_cost_bends_no_line() {
        let rung = |samples: u32| {
            let n = f64::from(samples);
            Rung { samples, errors: vec![1.0 / n; 3], seconds: vec![2e-5 + 1e-6 * n; 3], ..Rung::default() }
        };
        let found = curve(&[rung(4), rung(16), rung(64)], 0).unwrap();
        assert!((found.slope.unwrap().value + 1.0).abs() < 1e-12);
        let [percent, tenth] = [0, 1].map(|goal| found.seconds_to[goal].unwrap().value);
        assert!((percent / 1.2e-4 - 1.0).abs() < 1e-9 && (tenth / 1.02e-3 - 1.0).abs() < 1e-9);
        // A fixed part below none is noise, and so is a sample that takes less than no time.
        let seconds = |seconds: [f64; 2]| {
            let rung = |(samples, seconds): (u32, f64)| Rung {
                samples,
                errors: vec![],
                seconds: vec![seconds],
                ..Rung::default()
            };
            time(&[rung((1, seconds[0])), rung((4, seconds[1]))], &[0])
        };
        let (quick, slow) = (seconds([1.0, 8.0]), seconds([2.0, 1.0]));
        assert!(quick.fixed == 0.0 && (1.0..2.0).contains(&quick.of_sample));
        assert!(slow.of_sample == 0.0 && (1.0..2.0).contains(&slow.fixed));
    }

    #[test]
    fn slopes_hold_the_truth_as_often_as_they_say_even_if_it_is_none() {
        const TRIALS: u64 = 1000;
        let mut stream = Stream::named("slopes", 0);
        for seeds in [4, 8] {
            let mut holds = |trial: u64| {
                let mut rung = |samples: u32| {
                    let errors = (0..seeds).map(|_| 1.0 + 0.1 * stream.normal()).collect();
                    Rung { samples, errors, seconds: vec![f64::from(samples); seeds], ..Rung::default() }
                };
                let rungs = [rung(4), rung(16), rung(64)];
                let Measured { low, high, .. } = curve(&rungs, trial).unwrap().slope.unwrap();
                low < 0.0 && 0.0 < high
            };
            let share = (0..TRIALS).filter(|trial| holds(*trial)).count() as f64 / TRIALS as f64;
            assert!((share - 0.95).abs() < 0.021 + 0.01, "{seeds}: {share}");
        }
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        const TRIALS: u64 = 1000;
        let mut stream = Stream::named("curves", 0);
        for seeds in [3, 4, 8, 16] {
            let mut holds = |trial: u64| {
                let errors = (0..seeds).map(|_| 1.0 + 0.1 * stream.normal()).collect();
                let rung = Rung { samples: 1, errors, seconds: vec![1.0; seeds], ..Rung::default() };
                let Measured { low, high, .. } = curve(&[rung], trial).unwrap().errors[0];
                low < 1.0 && 1.0 < high
            };
            let share = (0..TRIALS).filter(|trial| holds(*trial)).count() as f64 / TRIALS as f64;
            // Three standard errors, and 0.01 for percentiles of few seeds.
            assert!((share - 0.95).abs() < 0.021 + 0.01, "{seeds}: {share}");
        }
    }

    #[test]
    fn one_seed_has_no_interval() {
        assert!(
            curve(&[Rung { samples: 1, errors: vec![1.0], seconds: vec![1.0], ..Rung::default() }], 0)
                .is_none()
        );
        assert!(curve(&[], 0).is_none());
    }
}
