//! Images as OpenEXR files.
//!
//! The first part holds the means as 32-bit floats under the channels' names and their variances under
//! `variance.NAME`. The data window is the crop window, the display window the full film. Provenance stands
//! in the header as `etalon.NAME`, and `etalon.hash` with it, the [`hash`] of all values: chunks that do not
//! become smaller are stored as they are, and nothing else would notice their damage. A shard has a second part,
//! [`SHARD_PART`], with the words of the accumulators as unsigned integers: `NAME.00` and on, in the order of
//! `ChannelAccumulator::word`; leaving a part out is easy for every reader, so a shard looks like any other image to
//! a viewer.

pub(super) mod claim;
pub(super) mod colors;
mod hash;
mod names;
mod read;
mod samples;
mod write;

pub use names::check_names;
pub use read::read_exr;
pub(super) use read::read_head;
pub use write::write_exr;

#[cfg(test)]
pub(super) use write::encode;

/// Name of the part that holds a shard's accumulators.
const SHARD_PART: &str = "accumulators";

/// Prefix of the attributes that hold the provenance.
const PREFIX: &str = "etalon.";

/// Name of the attribute, after the prefix, that holds the [`hash`] of the values.
const HASH: &str = "hash";

/// Prefix of the channels that hold variances.
const VARIANCE: &str = "variance.";

/// Name of the channel that holds one word of the accumulators of the channel `name`.
fn word_name(name: &str, word: usize) -> String {
    format!("{name}.{word:02}")
}

#[cfg(test)]
mod tests;
