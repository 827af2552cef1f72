//! Which emitter to sample.

use super::AnyEmitter;
use crate::math::{DVec2, Discrete};
use crate::shape::Geometry;

/// All emitters of a scene.
#[derive(Debug, Default)]
pub struct Emitters {
    pub list: Vec<Entry>,
    /// The one that surrounds the scene.
    pub environment: Option<usize>,
    choice: Discrete,
}

/// An emitter, and the shape it belongs to.
#[derive(Debug)]
pub struct Entry {
    pub emitter: AnyEmitter,
    pub shape: Option<u32>,
}

impl Emitters {
    /// Emitters are chosen by power, one part in ten evenly, so that an estimate of power that is wrong for some
    /// corner of the scene costs at most a tenth of its samples.
    pub fn new<'a>(list: Vec<Entry>, radius: f64, shape: impl Fn(u32) -> &'a Geometry) -> Self {
        const EVEN: f64 = 0.1;
        let powers: Vec<f64> = list.iter().map(|e| e.emitter.power(e.shape.map(&shape), radius)).collect();
        let total: f64 = powers.iter().sum();
        let n = list.len() as f64;
        let known = total > 0.0 && total.is_finite();
        let weight = |p: &f64| if known { (1.0 - EVEN) * p / total + EVEN / n } else { 1.0 / n };
        let choice = Discrete::new(powers.iter().map(weight));
        let environment = list.iter().position(|e| e.emitter.is_environment());
        Self { list, environment, choice }
    }

    /// The emitter that the first of two numbers in [0, 1) falls on, its probability, and the numbers to be used again;
    /// see [`Discrete::sample_strip`].
    #[inline]
    pub fn sample(&self, u: DVec2, digits: f64) -> Option<(usize, f64, DVec2)> {
        match self.list.len() {
            0 => None,
            1 => Some((0, 1.0, u)),
            _ => Some(self.choice.sample_strip(u, digits)),
        }
    }

    /// The probability of choosing emitter `index`.
    #[inline]
    pub fn probability(&self, index: usize) -> f64 {
        if self.list.len() == 1 { 1.0 } else { self.choice.probability(index) }
    }
}
