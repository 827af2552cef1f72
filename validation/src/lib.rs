//! Tests of light transport that depend on no renderer.
//!
//! - [`statistics`]: p-values, multiplicity, equivalence and power.
//! - [`image`]: comparison of two noisy images of the same scene, and where they differ.
//! - [`scatterer`] and [`checks`]: consistency of a scattering distribution (BSDF, phase function).
//! - [`converge`]: error against run time.
//! - [`peer`]: scattering distributions in other programs.
//! - [`chart`]: distributions over rectangles, tested by the same checks.
//! - [`microfacet`]: the albedo of single scattering at rough surfaces, from the definitions.
//! - [`html`]: escaping of text in HTML.
//! - [`report`]: the outcome of a check, and reports as JSON documents.
//!
//! Every verdict has three values, [`Verdict`]: a test that could not have detected a fault is inconclusive
//! instead of passing.

pub mod chart;
pub mod checks;
pub mod converge;
pub mod html;
pub mod image;
pub mod microfacet;
pub mod peer;
pub mod quadrature;
mod relative_error;
pub mod report;
pub mod scatterer;
pub mod statistics;

#[cfg(test)]
mod subjects;

pub use report::{Outcome, Report};
pub use scatterer::{Laws, Sample, Scatterer};
pub use statistics::Verdict;
