//! Does the value at a wavelength depend on the other wavelengths of the path?
//!
//! A path carries several wavelengths at once. Results at one of them must not depend on the others: values
//! must be identical, and so must the expected flux of samples, although lobes may be chosen with other
//! probabilities. Blind to errors of models that know one wavelength only.

use super::{Check, Effort, draw, fluxes::compare, relative_difference, show};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Scatterer},
    statistics::{Stream, Verdict, seed_for},
};

pub(super) const CHECK: Check = Check {
    name: "spectral",
    about: "value and flux at a wavelength do not depend on the wavelengths beside it",
    applies: |scatterer| !scatterer.companions().is_empty(),
    outcomes: |scatterer, wo, seeds, effort| {
        seeds.iter().map(|&seed| run(scatterer, wo, seed, effort)).collect()
    },
};

/// Largest difference of a flux moment that counts as equivalent.
const MARGIN: f64 = 0.0025;

/// Factor on the number of samples with [`Effort::thorough`]: dispersion ends all wavelengths but one of
/// eight.
const LANES: usize = 8;

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let companions = scatterer.companions();
    let mut stream = Stream::new(seed_for("pairs", seed));
    for _ in 0..effort.samples.div_ceil(256) {
        let Some(wi) = draw(scatterer, wo, &mut stream).filter(|s| !s.delta).map(|s| s.wi) else { continue };
        let own = scatterer.value(wo, wi);
        for companion in &companions {
            let value = companion.value(wo, wi);
            let error = relative_difference(own, value);
            if error.is_nan() || error > effort.tolerance {
                let message = format!("the value is {own} or {value} at {}, as the company has it", show(wi));
                return Outcome::new("spectral", Verdict::Different, message);
            }
        }
    }
    let samples = if effort.thorough { LANES * effort.samples } else { effort.samples };
    let level = crate::statistics::sidak(effort.level, companions.len());
    let effort = Effort { samples, level, ..*effort };
    let answers = companions
        .iter()
        .map(|companion| compare([scatterer, companion.as_ref()], wo, seed, MARGIN, &effort));
    let worst = answers.max_by_key(|(verdict, _)| *verdict);
    let (verdict, message) =
        worst.unwrap_or((Verdict::Inconclusive, "it knows of no other wavelength".into()));
    Outcome::new("spectral", verdict, message)
}
