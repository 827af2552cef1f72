//! Checks evaluate one query at a time, while another program answers thousands at the cost of one.
//!
//! So a check runs against a cache of answers. A query without an answer is recorded and gets a placeholder;
//! after the run all recorded queries go to the peer in one batch, and the check runs again. Checks are
//! deterministic functions of the answers they get, so a run in which no answer is missing is the run they
//! would have made directly, and each pass answers at least the first query that got a placeholder in the one
//! before.

use std::{cell::RefCell, f64::consts::FRAC_1_PI};

use super::known::{Key, Known};
use super::{Lines, Peer, PeerError};
use crate::scatterer::{DVec3, Laws, Sample, Scatterer};

/// Number of passes after which a check counts as endless. The checks need about as many as quadrature has
/// levels.
const MOST_PASSES: usize = 2000;

/// Runs a check on a configuration of `peer`, given by its index. Errors: the peer's, and a check that never
/// ends.
pub fn judge<L: Lines, T>(
    peer: &mut Peer<L>,
    configuration: usize,
    check: impl Fn(&dyn Scatterer) -> T,
) -> Result<T, PeerError> {
    let claims = peer.hello.configurations[configuration].laws;
    let memory =
        Memory { laws: claims.laws(), phase_function: claims.phase_function, answers: RefCell::default() };
    for pass in 0..MOST_PASSES {
        let outcome = check(&memory);
        let (pairs, draws) = memory.unknown();
        if pairs.is_empty() && draws.is_empty() {
            return Ok(outcome);
        }
        memory.learn(peer, configuration, &pairs, &draws)?;
        if pass == 0 {
            let begin = (&pairs[..pairs.len().min(TWICE)], &draws[..draws.len().min(TWICE)]);
            memory.confirm(peer, configuration, begin)?;
        }
    }
    Err(PeerError(format!("a check was not through after {MOST_PASSES} rounds of questions")))
}

/// ωo and the three numbers of a sample.
type Draw = (DVec3, [f64; 3]);

/// Number of the first questions that are asked twice.
const TWICE: usize = 16;

fn changed(request: &str, question: &str) -> PeerError {
    PeerError(format!("the peer gives two answers to the same question: `{request}` with {question}"))
}

#[derive(Default)]
struct Answers {
    pairs: Known<[f64; 2]>,
    draws: Known<Option<Sample>>,
    unknown_pairs: Vec<[DVec3; 2]>,
    unknown_draws: Vec<Draw>,
    /// Number of values and densities that placeholders have stood for so far.
    unanswered: usize,
}

struct Memory {
    laws: Laws,
    phase_function: bool,
    answers: RefCell<Answers>,
}

impl Memory {
    /// Takes the queries recorded in the run that is over.
    fn unknown(&self) -> (Vec<[DVec3; 2]>, Vec<Draw>) {
        let Answers { pairs, draws, unknown_pairs, unknown_draws, .. } = &mut *self.answers.borrow_mut();
        pairs.again();
        draws.again();
        (std::mem::take(unknown_pairs), std::mem::take(unknown_draws))
    }

    fn learn<L: Lines>(
        &self,
        peer: &mut Peer<L>,
        configuration: usize,
        pairs: &[[DVec3; 2]],
        draws: &[Draw],
    ) -> Result<(), PeerError> {
        let evaluated = peer.evaluate(configuration, pairs)?;
        let sampled = peer.sample(configuration, draws)?;
        let mut answers = self.answers.borrow_mut();
        for (&[wo, wi], answer) in pairs.iter().zip(evaluated) {
            answers.pairs.learn(key(wo, wi.to_array()), answer);
        }
        for (&(wo, u), answer) in draws.iter().zip(sampled) {
            answers.draws.learn(key(wo, u), answer);
        }
        Ok(())
    }

    /// Asks again what has been answered. Error: another answer.
    fn confirm<L: Lines>(
        &self,
        peer: &mut Peer<L>,
        configuration: usize,
        (pairs, draws): (&[[DVec3; 2]], &[Draw]),
    ) -> Result<(), PeerError> {
        for (&[wo, wi], again) in pairs.iter().zip(peer.evaluate(configuration, pairs)?) {
            if self.evaluate(wo, wi).map(f64::to_bits) != again.map(f64::to_bits) {
                return Err(changed(
                    "evaluate",
                    &format!("wo = {:?} and wi = {:?}", wo.to_array(), wi.to_array()),
                ));
            }
        }
        let bits = |sample: Option<Sample>| {
            sample.map(|s| (s.wi.to_array().map(f64::to_bits), s.weight.to_bits(), s.pdf.to_bits(), s.delta))
        };
        for (&(wo, u), again) in draws.iter().zip(peer.sample(configuration, draws)?) {
            if bits(self.sample(wo, u)) != bits(again) {
                return Err(changed("sample", &format!("wo = {:?} and u = {u:?}", wo.to_array())));
            }
        }
        Ok(())
    }

    /// The placeholder is the uniform density over the sphere, so that checks continue. Quadrature asks
    /// [`Scatterer::unanswered`], and does not refine where it got one.
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> [f64; 2] {
        // A direction that is not finite has no density, and the peer need not be able to parse it.
        if !(wo.is_finite() && wi.is_finite()) {
            return [f64::NAN; 2];
        }
        let Answers { pairs, unknown_pairs, unanswered, .. } = &mut *self.answers.borrow_mut();
        let (answer, new) = pairs.ask(key(wo, wi.to_array()));
        if new {
            unknown_pairs.push([wo, wi]);
        }
        answer.copied().unwrap_or_else(|| {
            *unanswered += 1;
            [0.25 * FRAC_1_PI; 2]
        })
    }
}

impl Scatterer for Memory {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.evaluate(wo, wi)[0]
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.evaluate(wo, wi)[1]
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let Answers { draws, unknown_draws, .. } = &mut *self.answers.borrow_mut();
        let (answer, new) = draws.ask(key(wo, u));
        if new {
            unknown_draws.push((wo, u));
        }
        answer.copied().flatten()
    }

    fn unanswered(&self) -> usize {
        self.answers.borrow().unanswered
    }

    fn laws(&self) -> Laws {
        self.laws
    }

    fn is_phase_function(&self) -> bool {
        self.phase_function
    }
}

fn key(wo: DVec3, rest: [f64; 3]) -> Key {
    let [[a, b, c], [d, e, f]] = [wo.to_array(), rest].map(|v| v.map(f64::to_bits));
    [a, b, c, d, e, f]
}
