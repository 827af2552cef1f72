//! Joins the harness, which knows no renderer, to Etalon, which knows no harness.
//!
//! [`agreement`] compares values and densities with Mitsuba's golden ones. [`materials`] shows every material of the registry to the checks, [`peers`] the BSDFs of other programs;
//! [`references`] renders the reference scenes and compares them with the images that Mitsuba made.

pub mod agreement;
pub mod converge;
pub mod materials;
pub mod peers;
pub mod references;
pub mod renderers;
