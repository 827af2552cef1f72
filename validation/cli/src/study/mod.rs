//! Error against run time of several renderers on one scene.
//!
//! [`mod@bench`] renders what is missing into a folder, [`mod@line`] summarises the pictures of a renderer,
//! and [`pictures`] draws them. [`converge`](crate::converge) runs a study of one scene, and
//! [`table`](crate::table) of many.

pub mod bench;
pub mod line;
pub mod pictures;

use serde::{Deserialize, Serialize};
use validation::converge::Errors;
use validation::statistics::seed_for;

use crate::renderers::Took;

/// The effort of a study.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Settings {
    #[serde(flatten)]
    pub ladder: Ladder,
    pub seeds: u32,
    /// Samples of a reference picture over those of the longest rung.
    pub reference: f64,
    pub threads: usize,
    /// Whether processor time is counted instead of wall-clock time, for machines with other load.
    pub processor_time: bool,
}

impl Settings {
    /// A description: rungs, seeds, and the kind of time.
    pub fn words(&self) -> String {
        let clock = if self.processor_time { ", processor time" } else { "" };
        format!("rungs of {}, {} seeds{clock}", self.ladder.rungs().join(", "), self.seeds)
    }
}

/// The rungs in ascending order.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub enum Ladder {
    /// Seconds per rung; a pilot determines the sample counts.
    Seconds(Vec<f64>),
    /// Samples per pixel of each rung.
    Samples(Vec<u32>),
}

impl Ladder {
    /// Number of rungs.
    pub fn count(&self) -> usize {
        match self {
            Self::Seconds(seconds) => seconds.len(),
            Self::Samples(samples) => samples.len(),
        }
    }

    /// A description of each rung.
    pub fn rungs(&self) -> Vec<String> {
        match self {
            Self::Seconds(seconds) => seconds.iter().map(|s| format!("{s} s")).collect(),
            Self::Samples(samples) => samples.iter().map(|n| format!("{n} samples")).collect(),
        }
    }
}

/// The record of one picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    pub renderer: String,
    pub seed: u32,
    pub rung: usize,
    pub samples: u32,
    #[serde(flatten)]
    pub took: Took,
    pub errors: Errors,
    /// The errors against the means of all pictures of the reference but one.
    #[serde(default)]
    pub without: Vec<Errors>,
    /// The commit and the machine with which it was rendered.
    pub with: String,
}

/// Number of pictures in a renderer's reference.
pub const REFERENCES: u32 = 4;

/// A seed of less than 2³¹, for renderers with 31-bit seeds; seeds of pictures and of references differ
/// because `what` does.
pub fn seed(what: &str, number: u32) -> u32 {
    (seed_for(what, u64::from(number)) >> 33) as u32
}
