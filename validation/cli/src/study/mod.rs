//! Error against run time of several renderers on one scene.
//!
//! [`mod@bench`] renders what is missing into a folder, [`mod@line`] says what a renderer's pictures show of
//! it, and [`pictures`] draws them. [`converge`](crate::converge) asks for one scene, and
//! [`table`](crate::table) for many.

pub mod bench;
pub mod line;
pub mod pictures;

use serde::{Deserialize, Serialize};
use validation::converge::Errors;
use validation::statistics::seed_for;

use crate::renderers::Took;

/// How long to look.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Settings {
    #[serde(flatten)]
    pub ladder: Ladder,
    pub seeds: u32,
    /// Samples of a reference's picture over those of the longest rung.
    pub reference: f64,
    pub threads: usize,
    /// Seconds are those of the processor, for machines that do other things meanwhile.
    pub processor_time: bool,
}

impl Settings {
    /// In words: rungs, seeds, and whose seconds.
    pub fn words(&self) -> String {
        let clock = if self.processor_time { ", processor time" } else { "" };
        format!("rungs of {}, {} seeds{clock}", self.ladder.rungs().join(", "), self.seeds)
    }
}

/// What each rung is given, in ascending order.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub enum Ladder {
    /// A pilot finds the samples that take as long.
    Seconds(Vec<f64>),
    Samples(Vec<u32>),
}

impl Ladder {
    /// How many rungs there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Seconds(seconds) => seconds.len(),
            Self::Samples(samples) => samples.len(),
        }
    }

    /// What each rung is given, in words.
    pub fn rungs(&self) -> Vec<String> {
        match self {
            Self::Seconds(seconds) => seconds.iter().map(|s| format!("{s} s")).collect(),
            Self::Samples(samples) => samples.iter().map(|n| format!("{n} samples")).collect(),
        }
    }
}

/// One picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    pub renderer: String,
    pub seed: u32,
    pub rung: usize,
    pub samples: u32,
    #[serde(flatten)]
    pub took: Took,
    pub errors: Errors,
    /// The commit and the machine that it was rendered with.
    pub with: String,
}

/// Pictures of a renderer's reference.
pub const REFERENCES: u32 = 4;

/// Seeds of pictures and references never meet; renderers of 31-bit seeds can take them.
pub fn seed(what: &str, number: u32) -> u32 {
    (seed_for(what, u64::from(number)) >> 33) as u32
}
