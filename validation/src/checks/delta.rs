//! Do delta lobes lead to few directions, each as often as its probability says?
//!
//! Nothing else looks at them but the furnace, which sees the sum of all weights: a lobe that is spread and
//! called a delta lobe escapes the checks of densities, and a wrong probability spoils the weights of
//! techniques that are combined with others. Blind to lobes too rare to be drawn, and to what a weight should
//! be.

use super::{Check, Effort, always, draw, relative_difference, show};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Sample, Scatterer},
    statistics::{Stream, Verdict, binomial::binomial_two_sided, sidak},
};

pub(super) const CHECK: Check = Check {
    name: "delta",
    about: "samples of delta lobes come in few directions, each as often as its pdf says",
    applies: always,
    outcomes: |scatterer, wo, seeds, effort| {
        seeds.iter().map(|&seed| run(scatterer, wo, seed, effort)).collect()
    },
};

/// More delta lobes than layers of coats, panes and mixtures of them have.
const MOST: usize = 64;

/// A lobe, and how often it was drawn. What differs in probability or weight is another lobe, even in the
/// same direction.
struct Lobe {
    of: Sample,
    count: u64,
}

impl Lobe {
    fn has(&self, sample: &Sample, tolerance: f64) -> bool {
        (self.of.wi - sample.wi).length() <= tolerance
            && relative_difference(self.of.pdf, sample.pdf) <= tolerance
            && relative_difference(self.of.weight, sample.weight) <= tolerance
    }
}

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let mut stream = Stream::new(seed);
    let draws = effort.samples.div_ceil(16);
    let mut lobes: Vec<Lobe> = vec![];
    for _ in 0..draws {
        let Some(sample) = draw(scatterer, wo, &mut stream).filter(|sample| sample.delta) else { continue };
        match lobes.iter().position(|lobe| lobe.has(&sample, effort.tolerance)) {
            Some(known) => lobes[known].count += 1,
            None if lobes.len() == MOST => {
                let message = format!(
                    "samples that are said to be of delta lobes lead to more than {MOST} directions; one is {}",
                    show(sample.wi)
                );
                return Outcome::new("delta", Verdict::Different, message);
            }
            None => lobes.push(Lobe { of: sample, count: 1 }),
        }
    }
    let level = sidak(effort.level, lobes.len().max(1));
    let wrong = lobes.iter().find(|Lobe { of, count }| {
        let possible = of.pdf > 0.0 && of.pdf <= 1.0 + effort.tolerance;
        !possible || binomial_two_sided(*count, draws as u64, of.pdf.min(1.0)) <= level
    });
    let drawn: u64 = lobes.iter().map(|lobe| lobe.count).sum();
    let (verdict, message) = match wrong {
        Some(Lobe { of, count }) => {
            let share = *count as f64 / draws as f64;
            let message = format!(
                "the delta lobe towards {} is drawn with probability {share:.6}; its pdf is {:.6}",
                show(of.wi),
                of.pdf
            );
            (Verdict::Different, message)
        }
        None if lobes.is_empty() => (Verdict::Equivalent, "no delta lobe".to_owned()),
        None => {
            let message = format!("{drawn} of {draws} samples are of {} delta lobes", lobes.len());
            (Verdict::Equivalent, message)
        }
    };
    Outcome::new("delta", verdict, message)
        .figure("lobes", lobes.len() as f64)
        .figure("share", drawn as f64 / draws as f64)
}
