//! Joins the harness, which knows no renderer, to Etalon, which knows no harness.
//!
//! [`materials`] shows every material of the registry to the checks; [`references`] renders the reference scenes and
//! compares them with the images that Mitsuba made; [`closed_forms`] are scenes with an analytic answer, and
//! [`metamorphic`] pairs of scenes whose images must be alike.

pub mod closed_forms;
pub mod materials;
pub mod metamorphic;
pub mod references;
pub mod stage;
