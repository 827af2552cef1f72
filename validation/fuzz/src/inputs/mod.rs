//! Damaged files: every reader must read or refuse each, within a time limit and in memory that the file's
//! size bounds.
//!
//! An input is a function of the seed files, the format and a number ([`mutate`]), so any can be reproduced.
//! [`worker`] is a process that reads inputs one after the other, announces each, and may crash or hang;
//! [`watch`] starts it, detects that, and continues with the next input.
//!
//! Limits: no panic, [`HANG`] for an input, and the memory limit [`Format::memory`].

pub mod formats;
pub mod mutate;
pub mod seeds;
pub mod watch;
pub mod worker;

pub use formats::{FORMATS, Format};
use std::time::Duration;

/// Time limit of an input. Inputs are small; this is generous for a busy machine.
pub const HANG: Duration = Duration::from_secs(20);
