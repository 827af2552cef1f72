//! Joins the harness, which knows no renderer, to Etalon, which knows no harness.
//!
//! [`materials`] shows every material of the registry to the checks, [`limits`] those that should turn into
//! others, [`sampling`] all else that is drawn, and [`peers`] the BSDFs of other programs; [`furnace`]
//! measures energy over roughness and index, and [`agreement`] compares values and densities with Mitsuba's
//! golden ones. [`ledger`] keeps p-values, and [`images`] asks of real renders whether their comparison keeps
//! its promises.
//!
//! [`references`] renders the reference scenes and compares them with the images that Mitsuba made;
//! [`closed_forms`] are scenes with an analytic answer, and [`metamorphic`] pairs of scenes whose images must
//! be alike; [`stability`] asks the same of stiff and extreme scenes. [`guest`] shows references and closed
//! forms to any of the [`renderers`], and [`converge`] measures their error against their time, on one scene,
//! [`table`] on all of the convergence table, both by a [`study`]. [`museum`] asks whether all of this would notice a bug, and
//! [`report`] puts all of it on one page.

pub mod agreement;
pub mod calibrate;
pub mod closed_forms;
pub mod companions;
pub mod console;
pub mod converge;
mod crew;
pub mod distributions;
mod documents;
pub mod drawn_light;
pub mod drawn_places;
pub mod furnace;
pub mod guest;
pub mod images;
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
