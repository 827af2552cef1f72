//! Tests of light transport that depend on no renderer.
//!
//! - [`statistics`]: p-values, multiplicity, equivalence and power.
//! - [`image`]: are two noisy images of the same scene the same picture, and if not, where?
//! - [`scatterer`] and [`checks`]: is a scattering distribution (BSDF, phase function) consistent with
//!   itself?
//! - [`converge`]: error against run time.
//! - [`peer`]: scattering distributions in other programs.
//! - [`chart`]: distributions over rectangles go through the same checks.
//! - [`microfacet`]: what single scattering at rough surfaces loses, from the definitions.
//! - [`html`]: text in pages.
//! - [`report`]: what a check found, as one JSON document.
//!
//! Every answer has three values, [`Verdict`]: a test that could not have noticed a fault says so instead of
//! passing.

pub mod chart;
pub mod checks;
pub mod converge;
pub mod html;
pub mod image;
pub mod microfacet;
pub mod peer;
pub mod quadrature;
pub mod report;
pub mod scatterer;
pub mod statistics;

#[cfg(test)]
mod subjects;

pub use report::{Outcome, Report};
pub use scatterer::{Laws, Sample, Scatterer};
pub use statistics::Verdict;
