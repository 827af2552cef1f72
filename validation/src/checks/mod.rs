//! Checks of one scattering distribution seen from one direction.
//!
//! To add one: a file with `pub(super) const CHECK: Check` that opens by saying what it finds and what it
//! cannot, a line in [`CHECKS`], and a saboteur in `subjects` that this check and no weaker one rejects.

mod chi2;
mod finiteness;
mod fluxes;
mod furnace;
mod harmonics;
mod jacobian;
mod limits;
mod moments;
mod normalisation;
mod partition;
mod preimages;
mod reciprocity;
mod spectral;
#[cfg(test)]
mod trial;
mod weight;

use crate::{
    report::Outcome,
    scatterer::{DVec3, Sample, Scatterer},
    statistics::{Stream, Verdict, seed_for, sidak},
};

/// How hard to look and how sure to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Directions drawn for statistical checks; deterministic ones use a sixteenth.
    pub samples: usize,
    /// Probability with which one check may reject an honest model. A caller that runs many divides it with
    /// [`sidak`].
    pub level: f64,
    /// Relative difference that deterministic checks take for rounding.
    pub tolerance: f64,
    /// Values below this have no digits left, such as those under the normal range of an f32 model, and are
    /// not compared with one another.
    pub smallest: f64,
    /// The error of an albedo that must be detectable.
    pub albedo: f64,
    /// Look at more states and more functions than a run of the tests has time for, and ask again while the
    /// answer is inconclusive.
    pub thorough: bool,
}

impl Default for Effort {
    /// 2¹⁸ samples, level 10⁻³, tolerance 10⁻⁵, all values (a model evaluated in f32), albedo to 1 %.
    fn default() -> Self {
        Self { samples: 1 << 18, level: 1e-3, tolerance: 1e-5, smallest: 0.0, albedo: 0.01, thorough: false }
    }
}

/// One check.
pub struct Check {
    pub name: &'static str,
    /// One line: what must hold.
    pub about: &'static str,
    /// Whether the check has something to say about a model.
    pub applies: fn(&dyn Scatterer) -> bool,
    outcomes: fn(&dyn Scatterer, wo: DVec3, seeds: &[u64], effort: &Effort) -> Vec<Outcome>,
}

/// How often a check is asked at most where the answer is inconclusive, thoroughly.
const ASKINGS: usize = 4;

impl Check {
    /// Asks; thoroughly, again while the answer is inconclusive, each time of other samples and four times as
    /// many. All askings share the level. The p-value is that of the first: which is the last depends on what
    /// it says.
    pub fn run(&self, scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Outcome {
        let ask = |seed: u64, effort: &Effort| {
            let outcome = self.repeat(scatterer, wo, &[seed], effort).pop();
            outcome.unwrap_or_else(|| Outcome::new(self.name, Verdict::Inconclusive, "nothing was asked"))
        };
        if !effort.thorough {
            return ask(seed, effort);
        }
        let effort = Effort { level: sidak(effort.level, ASKINGS), ..*effort };
        let mut outcome = ask(seed, &effort);
        for asking in 1..ASKINGS {
            if outcome.verdict != Verdict::Inconclusive {
                break;
            }
            let more = Effort { samples: effort.samples << (2 * asking), ..effort };
            let seed = seed_for(&format!("asking {asking}"), seed);
            outcome = Outcome { p_value: outcome.p_value, ..ask(seed, &more) };
        }
        outcome
    }

    /// Asks once for each seed. What no seed decides, such as integrals, is computed once for all.
    pub fn repeat(
        &self,
        scatterer: &dyn Scatterer,
        wo: DVec3,
        seeds: &[u64],
        effort: &Effort,
    ) -> Vec<Outcome> {
        (self.outcomes)(scatterer, wo, seeds, effort)
    }
}

/// All checks.
pub static CHECKS: &[Check] = &[
    finiteness::CHECK,
    weight::CHECK,
    normalisation::CHECK,
    chi2::CHECK,
    furnace::CHECK,
    reciprocity::CHECK,
    jacobian::CHECK,
    moments::CHECK,
    spectral::CHECK,
    limits::CHECK,
];

/// The check called `name`.
pub fn find(name: &str) -> Option<&'static Check> {
    CHECKS.iter().find(|check| check.name == name)
}

/// Runs every check that applies. Each gets a seed of its own from `seed`.
pub fn run_all(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Vec<Outcome> {
    let applicable = CHECKS.iter().filter(|check| (check.applies)(scatterer));
    applicable.map(|check| check.run(scatterer, wo, seed_for(check.name, seed), effort)).collect()
}

/// Rejects if the p-value is at most the level (or NaN), else accepts if the test was sharp enough, else says
/// so.
fn judge(p_value: f64, level: f64, detectable: f64, margin: f64) -> Verdict {
    if p_value.is_nan() || p_value <= level {
        Verdict::Different
    } else if detectable <= margin {
        Verdict::Equivalent
    } else {
        Verdict::Inconclusive
    }
}

/// The largest error of an expectation, in standard deviations of what is compared with it, that p-values do
/// not show: in 10⁴ of them Kolmogorov and Smirnov's test at 10⁻³ finds a shift of all by 0.02. Where
/// quadrature leaves more, there is a verdict, which allows for it, but no p-value. That follows from the
/// density alone, not from what was drawn.
const BLURRED: f64 = 0.02;

/// A stream for looking around before the samples that are judged: of the first seed, and independent of all
/// of them.
fn pilot(seeds: &[u64]) -> Stream {
    Stream::new(seed_for("pilot", seeds.first().copied().unwrap_or(0)))
}

fn draw(scatterer: &dyn Scatterer, wo: DVec3, stream: &mut Stream) -> Option<Sample> {
    let u = [stream.uniform(), stream.uniform(), stream.uniform()];
    scatterer.sample(wo, u)
}

fn always(_: &dyn Scatterer) -> bool {
    true
}

/// |a − b| relative to the larger; 0 if both are 0, NaN or infinite if either is not finite.
fn relative_difference(a: f64, b: f64) -> f64 {
    if a == b && a.is_finite() { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

/// Whether a quantity changes by more than a tenth of the tolerance within the rounding of a direction, as it
/// does near its zeros and at its jumps: then there is nothing to compare.
fn has_no_digits(quantity: impl Fn(DVec3) -> f64, w: DVec3, tolerance: f64) -> bool {
    let middle = quantity(w);
    let across = w.any_orthonormal_vector();
    let other = w.cross(across);
    [across, -across, other, -other].into_iter().any(|tangent| {
        let nudged = (w + 4.0 * f64::EPSILON * tangent).normalize();
        relative_difference(quantity(nudged), middle) > 0.1 * tolerance
    })
}

fn show(direction: DVec3) -> String {
    format!("({}, {}, {})", direction.x, direction.y, direction.z)
}
