//! Do delta lobes lead to few directions, each as often as its probability says?
//!
//! Nothing else looks at them but the furnace, which sees the sum of all weights: a lobe that is spread and
//! called a delta lobe escapes the checks of densities, and a wrong probability spoils the weights of
//! techniques that are combined with others. Blind to lobes too rare to be drawn, and to what a weight should
//! be.

use super::{Check, Effort, always, draw, judge, relative_difference, show};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Sample, Scatterer},
    statistics::{
        Stream, Verdict, binomial::binomial_two_sided, power::detectable_difference, sidak, worst_of,
    },
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

/// Most draws, where a probability takes so many to be known, in units of [`Effort::samples`].
const PATIENCE: usize = 16;

/// A lobe, and how often it was drawn. What differs in probability or weight is another lobe, even in the
/// same direction.
pub(super) struct Lobe {
    pub of: Sample,
    pub count: u64,
}

impl Lobe {
    fn has(&self, sample: &Sample, tolerance: f64) -> bool {
        (self.of.wi - sample.wi).length() <= tolerance
            && relative_difference(self.of.pdf, sample.pdf) <= tolerance
            && relative_difference(self.of.weight, sample.weight) <= tolerance
    }

    fn probability(&self) -> f64 {
        self.of.pdf.clamp(0.0, 1.0)
    }
}

/// The delta lobes that are drawn for a direction.
#[derive(Default)]
pub(super) struct Lobes {
    pub list: Vec<Lobe>,
    draws: usize,
    /// A direction beyond the first [`MOST`].
    beyond: Option<DVec3>,
}

impl Lobes {
    /// Draws until there are so many draws in all, or too many lobes.
    pub fn draw(
        &mut self,
        scatterer: &dyn Scatterer,
        wo: DVec3,
        draws: usize,
        tolerance: f64,
        stream: &mut Stream,
    ) {
        while self.draws < draws && self.beyond.is_none() {
            self.draws += 1;
            let Some(sample) = draw(scatterer, wo, stream).filter(|sample| sample.delta) else { continue };
            match self.list.iter().position(|lobe| lobe.has(&sample, tolerance)) {
                Some(known) => self.list[known].count += 1,
                None if self.list.len() == MOST => self.beyond = Some(sample.wi),
                None => self.list.push(Lobe { of: sample, count: 1 }),
            }
        }
    }
}

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let (mut stream, mut lobes) = (Stream::new(seed), Lobes::default());
    let few = effort.samples.div_ceil(16);
    lobes.draw(scatterer, wo, few, effort.tolerance, &mut stream);
    // As many as it takes to know the probabilities that are stated: not those that are seen.
    let level = sidak(effort.level, lobes.list.len().max(1));
    let reach = detectable_difference(1.0, level, f64::INFINITY);
    let laws = scatterer.laws();
    let error_of_one = |lobe: &Lobe| {
        let p = lobe.probability();
        reach * (lobe.of.weight * laws.flux_factor(wo, lobe.of.wi)).abs() * (p * (1.0 - p)).sqrt()
    };
    let largest = lobes.list.iter().map(error_of_one).fold(0.0, worst_of);
    let enough = (largest / effort.albedo) * (largest / effort.albedo);
    let draws = (enough.min((PATIENCE * effort.samples) as f64).ceil() as usize).max(few);
    lobes.draw(scatterer, wo, draws, effort.tolerance, &mut stream);
    if let Some(direction) = lobes.beyond {
        let message = format!(
            "samples that are said to be of delta lobes lead to more than {MOST} directions; one is {}",
            show(direction)
        );
        return Outcome::new("delta", Verdict::Different, message);
    }
    let draws = lobes.draws;
    let possible = |lobe: &Lobe| lobe.of.pdf > 0.0 && lobe.of.pdf <= 1.0 + effort.tolerance;
    let p_value = |lobe: &Lobe| match possible(lobe) {
        true => binomial_two_sided(lobe.count, draws as u64, lobe.probability()),
        false => 0.0,
    };
    let detectable = largest / (draws as f64).sqrt();
    let drawn: u64 = lobes.list.iter().map(|lobe| lobe.count).sum();
    let wrong = lobes.list.iter().find(|lobe| judge(p_value(lobe), level, 0.0, 0.0) == Verdict::Different);
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
        None if lobes.list.is_empty() => (Verdict::Equivalent, "no delta lobe".to_owned()),
        None => {
            let message = format!(
                "{drawn} of {draws} samples are of {} delta lobes; an albedo wrong by {detectable:.1e} would show",
                lobes.list.len()
            );
            (judge(1.0, level, detectable, effort.albedo), message)
        }
    };
    Outcome::new("delta", verdict, message)
        .figure("lobes", lobes.list.len() as f64)
        .figure("share", drawn as f64 / draws as f64)
        .detectable(detectable)
}
