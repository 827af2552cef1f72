//! Error against run time of any renderers: docs/convergence.md.
//!
//! - [`error`]: the error of one picture against a noisy reference, with the reference's variance subtracted.
//! - [`mod@curve`]: replicates over a ladder of sample counts, summarised by a curve with an efficiency and a
//!   slope.
//! - [`compare`]: the efficiency ratio of two renderers with its interval.
//! - [`plot`], [`forest`] and [`page`]: drawings, with [`axis`] in common, and tables.
//! - [`calibration`]: the rate of false positives and the power of that comparison.

pub mod axis;
pub mod calibration;
pub mod compare;
pub mod curve;
pub mod error;
pub mod forest;
pub mod page;
pub mod plot;

pub use compare::{Ratio, mean, ratio, ratio_of_means};
pub use curve::{Curve, Measured, Rung, curve};
pub use error::{Errors, Picture, Reference, errors, reference, relative_squares, without_each};
