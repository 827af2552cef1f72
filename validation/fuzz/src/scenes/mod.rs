//! Random scenes, rendered by Etalon and by Mitsuba and compared.
//!
//! [`grammar`] writes scenes from the examples of Etalon's registries, so that a new model is included
//! automatically. [`known`] lists the differences whose causes are documented; scenes without them are
//! compared. [`casters`] writes rooms in which Etalon's techniques are compared with each other.

pub mod casters;
pub mod grammar;
pub mod judge;
pub mod known;
pub mod mitsuba;
pub mod models;
pub mod node;
pub mod vary;
