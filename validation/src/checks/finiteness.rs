//! Are all values, densities and samples valid numbers, also in extreme configurations?
//!
//! Poles, grazing directions down to a cosine of 10⁻¹², exact mirror and opposite directions, and the ends of
//! the unit cube. Values, densities and weights must be finite and not negative, directions of unit length.

use super::{Check, Effort, always, show};
use crate::{
    report::Outcome,
    scatterer::{DVec3, Scatterer, direction},
    statistics::{Stream, Verdict},
};

pub(super) const CHECK: Check = Check {
    name: "finiteness",
    about: "values, pdfs, weights and directions are numbers that make sense",
    applies: always,
    outcomes: |scatterer, wo, seeds, effort| {
        seeds.iter().map(|&seed| run(scatterer, wo, seed, effort)).collect()
    },
};

/// Cosines of the tested directions, on both sides of the surface.
const COSINES: [f64; 8] = [1.0, 1.0 - 1e-12, 1.0 - 1e-6, 0.5, 1e-3, 1e-6, 1e-9, 1e-12];

/// Random numbers of the tested samples: 0, the largest f64 below 1, numbers near both, and the middle.
const CORNERS: [f64; 6] = [0.0, 1e-300, 1e-9, 0.5, 1.0 - 1e-9, 1.0 - f64::EPSILON / 2.0];

fn run(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
    let mut stream = Stream::new(seed);
    let mut tried = 0u64;
    let result = stressed(wo).into_iter().try_for_each(|wo| {
        let count = effort.samples.div_ceil(16 * 32);
        let random =
            (0..count).map(|_| [stream.uniform(), stream.uniform(), stream.uniform()]).collect::<Vec<_>>();
        corners().chain(random).try_for_each(|u| {
            tried += 1;
            sound_sample(scatterer, wo, u)
        })?;
        stressed(wo).into_iter().try_for_each(|wi| {
            tried += 1;
            sound_values(scatterer, wo, wi)
        })
    });
    let outcome = match result {
        Ok(()) => Outcome::new("finiteness", Verdict::Equivalent, format!("{tried} evaluations make sense")),
        Err(message) => Outcome::new("finiteness", Verdict::Different, message),
    };
    outcome.figure("tried", tried as f64)
}

/// `wo`, its mirror directions and its opposite, and directions at every cosine of [`COSINES`] in the azimuth
/// of `wo`, opposite to it and perpendicular to it.
fn stressed(wo: DVec3) -> Vec<DVec3> {
    let mirrored = DVec3::new(-wo.x, -wo.y, wo.z);
    let own = [wo, mirrored, -wo, -mirrored];
    let azimuth = libm::atan2(wo.y, wo.x);
    let turns = [0.0, std::f64::consts::FRAC_PI_2, std::f64::consts::PI];
    let around = move |cosine: f64| turns.map(|turn| direction(cosine, azimuth + turn));
    own.into_iter().chain(COSINES.into_iter().flat_map(move |z| [z, -z]).flat_map(around)).collect()
}

fn corners() -> impl Iterator<Item = [f64; 3]> {
    let pairs = CORNERS.into_iter().flat_map(|x| CORNERS.map(|y| [x, y]));
    pairs.flat_map(|[x, y]| CORNERS.map(|z| [x, y, z]))
}

fn makes_sense(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

fn sound_values(scatterer: &dyn Scatterer, wo: DVec3, wi: DVec3) -> Result<(), String> {
    for (name, value) in [("value", scatterer.value(wo, wi)), ("pdf", scatterer.pdf(wo, wi))] {
        if !makes_sense(value) {
            return Err(format!("{name} is {value} for wo = {}, wi = {}", show(wo), show(wi)));
        }
    }
    Ok(())
}

fn sound_sample(scatterer: &dyn Scatterer, wo: DVec3, u: [f64; 3]) -> Result<(), String> {
    let Some(sample) = scatterer.sample(wo, u) else { return Ok(()) };
    let length = sample.wi.length();
    // An f32 direction is of unit length to 10⁻⁷.
    let unit = (length - 1.0).abs() <= 1e-6;
    if unit && makes_sense(sample.weight) && makes_sense(sample.pdf) && sample.pdf > 0.0 {
        return if sample.delta { Ok(()) } else { sound_values(scatterer, wo, sample.wi) };
    }
    let (weight, pdf) = (sample.weight, sample.pdf);
    let broken = if !unit {
        "a direction that is not of unit length"
    } else if pdf == 0.0 {
        "a sample of density 0, which should be none"
    } else {
        "a weight or density that is negative or not finite"
    };
    let at = format!("for wo = {}, u = {u:?}", show(wo));
    Err(format!("{broken}: weight {weight}, pdf {pdf}, |wi| = {length} {at}"))
}
