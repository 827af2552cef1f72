//! Does a model converge to its limit where a parameter ends?
//!
//! A rough surface of vanishing roughness is a smooth one, glass with the index of its surroundings is
//! invisible, and glass without dispersion is plain glass. Lobes of the model may be deltas of its limit, so
//! flux moments are compared: the total, the part that leaves upward, and the mean direction. Blind to shapes
//! of lobes.

use super::{Check, Effort, fluxes::compare};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::Verdict,
};

pub(super) const CHECK: Check = Check {
    name: "limits",
    about: "near the end of its parameters the model sends light where its limit does",
    applies: |scatterer| scatterer.limit().is_some(),
    outcomes: |scatterer, wo, seeds, effort| {
        seeds.iter().map(|&seed| run(scatterer, wo, seed, effort)).collect()
    },
};

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let Some(limit) = scatterer.limit() else {
        return Outcome::new("limits", Verdict::Inconclusive, "it has no limit");
    };
    let prepared = limit.scatterer.prepared();
    let models = [scatterer, prepared.as_deref().unwrap_or(limit.scatterer)];
    let (verdict, message) = compare(models, wo, seed, limit.within, effort);
    Outcome::new("limits", verdict, message).figure("margin", limit.within)
}
