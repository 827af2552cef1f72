//! Checks of one scattering distribution for one outgoing direction.
//!
//! To add one: a file with `pub(super) const CHECK: Check` whose documentation begins with what it finds and
//! what it cannot find, a line in [`CHECKS`], and a saboteur in `subjects` that this check and no weaker one
//! rejects.

mod chi2;
mod delta;
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

/// The effort of a check: sample counts, significance level and tolerances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Directions drawn for statistical checks; deterministic ones use a sixteenth.
    pub samples: usize,
    /// Probability with which one check may reject a correct model. A caller that runs many divides it with
    /// [`sidak`].
    pub level: f64,
    /// Relative difference that deterministic checks attribute to rounding.
    pub tolerance: f64,
    /// Values below this have no significant digits left, such as those below the normal range of an f32
    /// model, and are not compared with one another.
    pub smallest: f64,
    /// The error of an albedo that must be detectable.
    pub albedo: f64,
    /// Test more states and more functions than a run of the test suite has time for, and repeat with more
    /// samples while the verdict is inconclusive.
    pub thorough: bool,
}

impl Default for Effort {
    /// 2¹⁸ samples, level 10⁻³, tolerance 10⁻⁵, no value too small to compare, albedo to 1 %: for a model
    /// evaluated in f32.
    fn default() -> Self {
        Self { samples: 1 << 18, level: 1e-3, tolerance: 1e-5, smallest: 0.0, albedo: 0.01, thorough: false }
    }
}

/// One check.
pub struct Check {
    pub name: &'static str,
    /// One line: what must hold.
    pub about: &'static str,
    /// Whether the check applies to a model.
    pub applies: fn(&dyn Scatterer) -> bool,
    outcomes: fn(&dyn Scatterer, wo: DVec3, seeds: &[u64], effort: &Effort) -> Vec<Outcome>,
}

/// Largest number of repetitions of an inconclusive check, the first run included, with [`Effort::thorough`].
const ASKINGS: usize = 4;

impl Check {
    /// Runs the check. With [`Effort::thorough`] it is repeated while the verdict is inconclusive, each time
    /// with other seeds and four times as many samples. All repetitions share the level. The p-value is that
    /// of the first run: whether there is another depends on the result.
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

    /// Runs the check once for each seed. Whatever does not depend on the seed, such as integrals, is
    /// computed once.
    pub fn repeat(
        &self,
        scatterer: &dyn Scatterer,
        wo: DVec3,
        seeds: &[u64],
        effort: &Effort,
    ) -> Vec<Outcome> {
        let prepared = scatterer.prepared();
        (self.outcomes)(prepared.as_deref().unwrap_or(scatterer), wo, seeds, effort)
    }
}

/// All checks.
pub static CHECKS: &[Check] = &[
    finiteness::CHECK,
    weight::CHECK,
    delta::CHECK,
    normalisation::CHECK,
    chi2::CHECK,
    furnace::CHECK,
    reciprocity::CHECK,
    jacobian::CHECK,
    moments::CHECK,
    spectral::CHECK,
    limits::CHECK,
];

/// The check with this name.
pub fn find(name: &str) -> Option<&'static Check> {
    CHECKS.iter().find(|check| check.name == name)
}

/// Runs every check that applies, each with its own seed derived from `seed`.
pub fn run_all(scatterer: &dyn Scatterer, wo: DVec3, seed: u64, effort: &Effort) -> Vec<Outcome> {
    let applicable = CHECKS.iter().filter(|check| (check.applies)(scatterer));
    applicable.map(|check| check.run(scatterer, wo, seed_for(check.name, seed), effort)).collect()
}

/// Rejects if the p-value is at most the level (or NaN), else accepts if the detectable effect is at most the
/// margin, else is inconclusive.
fn judge(p_value: f64, level: f64, detectable: f64, margin: f64) -> Verdict {
    if p_value.is_nan() || p_value <= level {
        Verdict::Different
    } else if detectable <= margin {
        Verdict::Equivalent
    } else {
        Verdict::Inconclusive
    }
}

/// Largest error of an expectation, in standard deviations of the compared quantity, that does not show in
/// p-values: in 10⁴ of them, Kolmogorov and Smirnov's test at 10⁻³ finds a common shift of 0.02. Where
/// quadrature leaves a larger error, there is a verdict, which allows for it, but no p-value. That decision
/// depends on the density alone, not on the samples.
const BLURRED: f64 = 0.02;

/// The stream of the pilot sample: it depends on the first seed only, and is independent of the judged
/// samples of all seeds.
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
/// does near its zeros and at its jumps: then it has no significant digits to compare.
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
