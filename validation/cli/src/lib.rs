//! Joins the harness, which knows no renderer, to Etalon, which knows no harness.
//!
//! [`materials`] shows every material of the registry to the checks, [`limits`] those that should turn into others, and
//! [`sampling`] all else that is drawn; [`furnace`] measures energy over roughness and index. [`ledger`] keeps p-values. [`references`] renders the reference scenes and compares
//! them with the images that Mitsuba made.

pub mod companions;
pub mod drawn_light;
pub mod drawn_places;
pub mod furnace;
pub mod ledger;
pub mod limits;
pub mod materials;
pub mod references;
pub mod sampling;
pub mod trial;
pub mod warps;
