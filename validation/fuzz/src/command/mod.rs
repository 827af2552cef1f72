//! One file per command; each has arguments and a `run`, which says whether nothing was found.

pub mod input;
pub mod paths;
mod record;
pub mod scenes;
pub mod techniques;

use std::ops::Range;
use std::path::{Path, PathBuf};

/// Where the files of random scenes are.
fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../references/scenes")
}

/// Parses numbers of scenes.
fn range(text: &str) -> Result<Range<u64>, String> {
    let number = |text: &str| text.parse::<u64>().map_err(|_| "expected such as 0..500 or 7".to_string());
    let Some((from, to)) = text.split_once("..") else { return number(text).map(|n| n..n + 1) };
    Ok(number(from)?..number(to)?)
}
