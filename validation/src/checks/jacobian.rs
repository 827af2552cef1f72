//! Is the density the inverse Jacobian of the sampling map?
//!
//! No statistics: a draw is a map from the unit square (the first number, which chooses the lobe, is held
//! fixed) to directions, so its density is the share of first numbers that choose this lobe over |∂ω/∂u ×
//! ∂ω/∂v|. Sixth-order differences give the Jacobian and, by halving their step, its error. Where the stated
//! density is larger, other lobes must reach the same direction: their preimages are found (`preimages`) and
//! their densities added. A stated density smaller than that of one lobe alone is wrong at once.
//!
//! States in which the difference quotient or the density itself has too few significant digits are left out,
//! counted and printed; so are states of a mixture whose sum stays too small, since a preimage may have been
//! missed. If either exceeds 1 %, the check is inconclusive, or fails in the case of the sum. Cannot detect a
//! wrong weight, nor errors that the map and its density have in common.

use super::{
    Check, Effort, always, has_no_digits, pilot,
    preimages::{Map, Preimages},
    relative_difference, show,
};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{Stream, Verdict},
};

pub(super) const CHECK: Check = Check {
    name: "jacobian",
    about: "the pdf times the Jacobian of the sampling is 1, lobe by lobe",
    applies: always,
    outcomes,
};

/// Relative error above which the density is wrong.
const TOLERANCE: f64 = 1e-6;

/// Largest share of states that may be left out.
const LEFT_OUT: f64 = 0.01;

/// Number of states in tests, and with [`Effort::thorough`].
const STATES: [usize; 2] = [256, 10_000];

#[derive(Default)]
struct Tally {
    checked: usize,
    blurred: usize,
    short: usize,
    wrong: usize,
    worst: f64,
    place: Option<(DVec3, f64, f64)>,
}

enum State {
    /// The sum of the densities found, and whether it is complete.
    Known { found: f64, complete: bool },
    /// Rounding leaves too few significant digits.
    Blurred,
}

fn outcomes(scatterer: &dyn Scatterer, wo: DVec3, seeds: &[u64], effort: &Effort) -> Vec<Outcome> {
    let map = Map { scatterer, wo };
    let preimages = Preimages::new(&map, &mut pilot(seeds));
    seeds.iter().map(|&seed| judge(&map, &preimages, seed, effort)).collect()
}

fn judge(map: &Map, preimages: &Preimages, seed: u64, effort: &Effort) -> Outcome {
    let mut stream = Stream::new(seed);
    let mut tally = Tally::default();
    for _ in 0..STATES[usize::from(effort.thorough)] {
        let (lobe, v) = (stream.uniform(), [stream.uniform(), stream.uniform()]);
        let Some(wi) = map.at(lobe, v) else { continue };
        let stated = map.scatterer.pdf(map.wo, wi);
        tally.checked += 1;
        match look(map, preimages, lobe, v, wi, stated) {
            State::Blurred => tally.blurred += 1,
            State::Known { found, complete } => {
                let error = relative_difference(found, stated);
                if error <= TOLERANCE {
                    tally.worst = tally.worst.max(error);
                } else if !complete && found < stated {
                    tally.short += 1;
                } else {
                    tally.wrong += 1;
                    tally.place = tally.place.or(Some((wi, stated, found)));
                }
            }
        }
    }
    conclude(&tally)
}

fn look(map: &Map, preimages: &Preimages, lobe: f64, v: [f64; 2], wi: DVec3, stated: f64) -> State {
    // A density that changes within the rounding of a direction has no significant digits to compare.
    if has_no_digits(|wi| map.scatterer.pdf(map.wo, wi), wi, TOLERANCE) {
        return State::Blurred;
    }
    let Some(own) = map.density(lobe, v) else { return State::Blurred };
    if own.error > 0.25 * TOLERANCE {
        return State::Blurred;
    }
    if stated.is_nan() || own.value > stated * (1.0 - TOLERANCE) || !preimages.several() {
        return State::Known { found: own.value, complete: true };
    }
    let found = preimages.sum(map, wi, own.value, v, stated, TOLERANCE);
    State::Known { found, complete: false }
}

fn conclude(tally: &Tally) -> Outcome {
    let Tally { checked, blurred, short, wrong, worst, place } = *tally;
    let most = LEFT_OUT * checked as f64;
    let verdict = if wrong > 0 || short as f64 > most {
        Verdict::Different
    } else if (blurred + short) as f64 > most {
        Verdict::Inconclusive
    } else {
        Verdict::Equivalent
    };
    let left_out = format!("{blurred} of {checked} states are ill-conditioned, {short} lack a preimage");
    let message = match place {
        Some((wi, stated, found)) => format!(
            "the pdf at {} is {stated:.9e}, the sampling's density {found:.9e}; {wrong} states are wrong; {left_out}",
            show(wi)
        ),
        None if checked == 0 => "no density and no sample outside delta lobes".into(),
        None => format!("pdf times Jacobian is 1 within {worst:.1e}; {left_out}"),
    };
    Outcome::new("jacobian", verdict, message)
        .figure("checked", checked as f64)
        .figure("ill_conditioned", blurred as f64)
        .figure("short", short as f64)
        .figure("wrong", wrong as f64)
        .figure("worst", worst)
}
