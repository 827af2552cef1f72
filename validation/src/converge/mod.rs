//! Error against run time, whatever rendered: docs/convergence.md.
//!
//! - [`error`]: the error of one picture against a noisy reference, without the reference's share.
//! - [`mod@curve`]: replicates over a ladder of sample counts become a curve with an efficiency and a slope.
//! - [`compare`]: two renderers' efficiency ratio with its interval.
//! - [`plot`] and [`page`]: drawings and tables.
//! - [`calibration`]: whether what is called different is.

pub mod calibration;
pub mod compare;
pub mod curve;
pub mod error;
pub mod page;
pub mod plot;

pub use compare::{Ratio, mean, ratio};
pub use curve::{Curve, Interval, Rung, curve};
pub use error::{Errors, Picture, Reference, errors, reference, relative_squares};
