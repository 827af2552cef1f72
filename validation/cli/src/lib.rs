//! Joins the harness, which knows no renderer, to Etalon, which knows no harness.
//!
//! [`materials`] shows every material of the registry to the checks and [`peers`] the BSDFs of other programs;
//! [`agreement`] compares values and densities with Mitsuba's golden ones. [`references`] renders the reference scenes
//! and compares them with the images that Mitsuba made; [`closed_forms`] are scenes with an analytic answer, and
//! [`metamorphic`] pairs of scenes whose images must be alike. [`converge`] measures the error of [`renderers`] against
//! their time. [`museum`] asks whether all of this would notice a bug.

pub mod agreement;
pub mod closed_forms;
pub mod converge;
pub mod materials;
pub mod metamorphic;
pub mod museum;
pub mod peers;
pub mod references;
pub mod renderers;
pub mod stage;
