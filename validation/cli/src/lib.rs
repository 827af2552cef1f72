//! Joins the harness, which knows no renderer, to Etalon, which knows no harness.
//!
//! [`materials`] shows every material of the registry to the checks; [`references`] renders the reference scenes and
//! compares them with the images that Mitsuba made; [`museum`] asks whether the tests would notice a bug.

pub mod materials;
pub mod museum;
pub mod references;
