//! Random scenes, rendered by Etalon and by Mitsuba: the same picture?
//!
//! [`grammar`] writes scenes from the examples of Etalon's registries, so that a new model joins by itself.
//! [`known`] names the differences whose causes are written down; scenes without them are judged.

pub mod grammar;
pub mod judge;
pub mod known;
pub mod mitsuba;
pub mod models;
pub mod node;
pub mod vary;
