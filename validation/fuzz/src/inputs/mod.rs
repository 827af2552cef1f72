//! Damaged files: every reader must read or refuse, soon, and in memory that the file's size bounds.
//!
//! An input is a function of the seed files, the format and a number ([`mutate`]), so any can be made again.
//! [`worker`] is a process that reads one after the other, says which, and may die or hang; [`watch`] starts
//! it, sees that, and goes on after it.
//!
//! Stated limits: no panic, [`HANG`] for an input, and the memory that [`Format::memory`] says.

pub mod formats;
pub mod mutate;
pub mod seeds;
pub mod watch;
pub mod worker;

pub use formats::{FORMATS, Format};
use std::time::Duration;

/// An input may take this long. Inputs are small; this is generous for a busy machine.
pub const HANG: Duration = Duration::from_secs(20);
