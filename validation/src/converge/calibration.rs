//! The calibration of [`ratio`]: its rate of false positives and its power.
//!
//! A pool of pairs, each rendered one after the other by the same renderer with two seeds, has the true
//! distribution of errors and times on a busy machine. A trial draws a few pairs and exchanges the two
//! renders of a pair at random: then neither side is more efficient. Multiplying the times of one side makes
//! it less efficient by a known factor.

use serde::{Deserialize, Serialize};

use super::{Rung, ratio};
use crate::statistics::Stream;

/// Two renders of the same scene: for each, error and seconds of every rung.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pair(pub [Vec<[f64; 2]>; 2]);

/// The share of `trials` of `seeds` pairs in which the sides are called different, when the times of the
/// second side are multiplied by `factor`. `None` if the pool has too few pairs, or an error is not positive.
pub fn share_called_different(
    pool: &[Pair],
    seeds: usize,
    factor: f64,
    trials: u32,
    stream: &mut Stream,
) -> Option<f64> {
    if seeds > pool.len() {
        return None;
    }
    let mut called = 0;
    let mut order: Vec<usize> = (0..pool.len()).collect();
    for _ in 0..trials {
        let mut ladders = [vec![], vec![]];
        // The first steps of Fisher and Yates's shuffle.
        for k in 0..seeds {
            let left = order.len() - k;
            let other = k + ((stream.uniform() * left as f64) as usize).min(left - 1);
            order.swap(k, other);
            let turned = usize::from(stream.uniform() < 0.5);
            let Pair(sides) = &pool[order[k]];
            for (side, ladder) in ladders.iter_mut().enumerate() {
                for (step, [error, seconds]) in sides[side ^ turned].iter().enumerate() {
                    if ladder.len() == step {
                        ladder.push(Rung::default());
                    }
                    ladder[step].errors.push(*error);
                    ladder[step].seconds.push(if side == 1 { seconds * factor } else { *seconds });
                }
            }
        }
        called += u32::from(ratio(&ladders[0], &ladders[1], true)?.different);
    }
    Some(f64::from(called) / f64::from(trials))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pool(scatter: f64) -> Vec<Pair> {
        let mut stream = Stream::named("pool", 0);
        let mut side =
            || (0..3).map(|_| [1.0, 1.0].map(|v: f64| v * libm::exp(scatter * stream.normal()))).collect();
        (0..200).map(|_| Pair([side(), side()])).collect()
    }

    #[test]
    fn equal_sides_are_seldom_called_different_and_a_small_factor_often() {
        let mut stream = Stream::named("calibration", 0);
        let quiet = pool(0.02);
        let mut share = |factor: f64| share_called_different(&quiet, 8, factor, 2000, &mut stream).unwrap();
        // The level is 0.5 %; three standard errors of it in 2000 trials are 0.47 %.
        assert!(share(1.0) <= 0.0097);
        assert!(share(1.05) >= 0.9);
        // If errors scatter ten times as much, 5 % cannot be detected.
        let loud = pool(0.2);
        assert!(share_called_different(&loud, 8, 1.05, 500, &mut stream).unwrap() < 0.1);
        assert!(share_called_different(&loud, 201, 1.05, 1, &mut stream).is_none());
    }
}
