//! Correct models and saboteurs, which test the checks.

mod conductor;
mod dielectric;
mod lambert;
mod mixture;
mod relatives;
mod saboteur;

pub use conductor::Conductor;
pub use dielectric::{DiffuseDielectric, SmoothDielectric};
pub use lambert::Lambert;
pub use mixture::Mixture;
pub use relatives::{Coloured, Near};
pub use saboteur::{Fault, Sabotaged};

use crate::scatterer::{DVec3, direction};
use std::f64::consts::TAU;

/// A direction around ±z with density |cos θ|/π.
fn cosine_weighted(u: [f64; 2], side: f64) -> DVec3 {
    direction(side * (1.0 - u[0]).sqrt(), TAU * u[1])
}
