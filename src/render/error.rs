//! Why a render has no image.

use std::error::Error;
use std::fmt;

/// Why a render has no image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RenderError {
    /// [`Progress::stop`](super::Progress::stop) was set.
    Stopped,
    /// The threads cannot be started.
    Threads {
        /// How many; 0 means one for each processor.
        count: usize,
        why: String,
    },
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Stopped => write!(f, "the render was stopped"),
            Self::Threads { count, why } => write!(f, "{count} threads cannot be started: {why}"),
        }
    }
}

impl Error for RenderError {}
