//! Joins the harness, which knows no renderer, to Etalon, which knows no harness.
//!
//! [`materials`] applies the checks to every material of the registry, [`limits`] to those near the end of a
//! parameter, [`sampling`] to all other sampled distributions, and [`peers`] to the BSDFs of other programs;
//! [`furnace`] measures energy over roughness and index, and [`agreement`] compares values and densities with
//! Mitsuba's golden ones. [`ledger`] keeps p-values, [`images`] calibrates the comparison of images on real
//! renders, and [`intervals`] adds to an image how far its pixels may be from what they expect.
//!
//! [`references`] renders the reference scenes and compares them with the images that Mitsuba made;
//! [`closed_forms`] are scenes with an analytic solution, and [`metamorphic`] pairs of scenes whose images
//! must be equal; [`stability`] tests stiff and extreme scenes in the same way. [`guest`] tests any of the
//! [`renderers`] with references and closed forms, and [`converge`] measures their error against their time,
//! on one scene, [`table`] on all of the convergence table, both by a [`study`]. [`museum`] tests whether all
//! of this would detect a bug, and [`report`] puts all of it on one page.

pub mod agreement;
pub mod calibrate;
pub mod closed_forms;
pub mod companions;
pub mod console;
pub mod converge;
mod crew;
pub mod direction;
pub mod distributions;
mod documents;
pub mod drawn_light;
pub mod drawn_places;
mod files;
pub mod furnace;
pub mod guest;
pub mod images;
pub mod intervals;
pub mod ledger;
pub mod limits;
pub mod materials;
pub mod metamorphic;
pub mod museum;
pub mod peers;
pub mod provenance;
pub mod references;
pub mod renderers;
pub mod report;
pub mod sampling;
pub mod scenes;
pub mod stability;
pub mod stage;
pub mod study;
pub mod table;
pub mod trial;
pub mod warps;
