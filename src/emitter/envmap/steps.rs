//! Choices among a few, with probabilities that are whole numbers of steps.
//!
//! Numbers of 16 bits are a quarter as long as doubles: what one choice looks at lies in a cache line or two,
//! and tables that would wait in a far cache fit into a near one. Probabilities are rounded to whole steps,
//! none of what is possible to zero; since the rounded ones are what densities are made of, nothing is
//! approximate but how well choices follow weights.

use crate::math::{BELOW_ONE, Chosen};

/// Number of steps, which are distributed over the choices.
const STEPS: u16 = u16::MAX;

/// Distributes the steps in proportion to some weights, of which there are far fewer than steps: where those
/// of each begin. Nothing is chosen where no weight is positive.
pub fn deal(weights: &[f64]) -> impl Iterator<Item = u16> {
    let total: f64 = weights.iter().sum();
    let possible = weights.iter().filter(|weight| **weight > 0.0).count() as u16;
    // One for each that is possible, the others by weight.
    let (by_weight, mut sum, mut before) = (f64::from(STEPS - possible), 0.0, 0);
    weights.iter().map(move |weight| {
        let start = if total > 0.0 { before + (by_weight * (sum / total) + 0.5) as u16 } else { STEPS };
        sum += weight;
        before += u16::from(*weight > 0.0);
        start
    })
}

/// Chooses by u in [0, 1).
#[inline]
pub fn pick(starts: &[u16], u: f64) -> Option<Chosen> {
    let x = u * f64::from(STEPS);
    // Counting all is faster than a search: there are few, no branch depends on them, and registers hold
    // many.
    let begun: u16 = starts.iter().map(|start| u16::from(*start <= x as u16)).sum();
    let index = usize::from(begun).checked_sub(1)?;
    let (begin, steps) = span(starts, index);
    let rest = ((x - begin) / steps).min(BELOW_ONE);
    Some(Chosen { index, probability: steps / f64::from(STEPS), rest })
}

/// The probability of choosing an index.
#[inline]
pub fn probability(starts: &[u16], index: usize) -> f64 {
    span(starts, index).1 / f64::from(STEPS)
}

/// Where the steps of an index begin, and how many there are.
#[inline]
fn span(starts: &[u16], index: usize) -> (f64, f64) {
    let (begin, end) = (starts[index], starts.get(index + 1).copied().unwrap_or(STEPS));
    (f64::from(begin), f64::from(end - begin))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dealt(weights: &[f64]) -> Vec<u16> {
        deal(weights).collect()
    }

    #[test]
    fn probabilities_are_near_the_weights_and_sum_to_one() {
        let weights = [0.0, 3.0, 1e-20, 0.0, 5.0, 1e9, 0.25e9, 0.0];
        let (starts, total) = (dealt(&weights), weights.iter().sum::<f64>());
        let probabilities: Vec<f64> = (0..weights.len()).map(|i| probability(&starts, i)).collect();
        assert_eq!(probabilities.iter().sum::<f64>(), 1.0);
        for (weight, probability) in weights.iter().zip(probabilities) {
            assert_eq!(*weight > 0.0, probability > 0.0);
            assert!((probability - weight / total).abs() < 6.0 / f64::from(STEPS));
        }
    }

    #[test]
    fn choices_have_their_probability_and_leave_a_number_behind() {
        let starts = dealt(&[0.5, 0.0, 2.0, 1.0, 0.0]);
        const COUNT: usize = 1 << 18;
        let mut found = [0.0; 5];
        for i in 0..COUNT {
            let choice =
                pick(&starts, (i as f64 + 0.5) / COUNT as f64).expect("there is something to choose");
            assert_eq!(choice.probability, probability(&starts, choice.index));
            assert!((0.0..1.0).contains(&choice.rest));
            found[choice.index] += 1.0 / COUNT as f64;
        }
        for (index, found) in found.into_iter().enumerate() {
            assert!((found - probability(&starts, index)).abs() < 2.0 / COUNT as f64);
        }
    }

    #[test]
    fn the_ends_of_the_range_choose_what_is_possible() {
        let starts = dealt(&[0.0, 0.1, 0.0, 0.3, 0.0]);
        let index = |u: f64| pick(&starts, u).map(|choice| choice.index);
        assert_eq!((index(0.0), index(BELOW_ONE)), (Some(1), Some(3)));
        assert_eq!(pick(&dealt(&[0.0, 0.0]), 0.5), None);
        assert_eq!(pick(&dealt(&[7.0]), 0.25), Some(Chosen { index: 0, probability: 1.0, rest: 0.25 }));
    }
}
