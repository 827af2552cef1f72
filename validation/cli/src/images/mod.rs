//! `validate images`: two images, or the comparison itself.

pub mod calibration;
pub mod command;
