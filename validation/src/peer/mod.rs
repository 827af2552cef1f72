//! Scattering distributions in other programs, in any language: docs/peer-protocol.md.
//!
//! - [`Process`] exchanges lines with another program, within a time limit.
//! - [`Peer`] implements the protocol over such lines.
//! - [`judge`] runs a check of this crate on one configuration of a peer.

mod known;
mod memory;
mod process;
mod protocol;

pub use memory::judge;
pub use process::{Process, ends_or_is_killed, words};
pub use protocol::{Configuration, Hello, Lines, Peer};

/// The reason why a peer gave no answer, in one sentence for a person.
#[derive(Clone, Debug, PartialEq)]
pub struct PeerError(pub String);

impl std::fmt::Display for PeerError {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for PeerError {}

#[cfg(test)]
mod tests;
