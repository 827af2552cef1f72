//! The film: its size, filters and channels, and what a pixel remembers of its samples, independent of the order
//! in which they arrive.
//!
//! A render is a function of scene, seed and sample range, so the numbers a pixel ends with must not depend
//! on threads, tiles, processes or the order of a merge. Two things make that so: consecutive samples are
//! grouped into fixed blocks of [`BLOCK`], each summed plainly in sample order; and the block sums are added
//! by [`ExactSum`], whose bits depend only on *which* values were added.
//!
//! [`ChannelAccumulator`] is one channel of one pixel, [`Accumulators`] a rectangle of pixels,
//! a [`Window`] such a rectangle's place on the film.

mod accumulator;
mod bands;
mod channel;
pub mod filter;
pub mod filter_sampler;
pub mod filter_weights;
mod grid;
mod parse;
mod settings;
mod window;

pub use accumulator::ExactSum;
pub use bands::Band;
pub use channel::{BLOCK, ChannelAccumulator};
pub use grid::Accumulators;
pub use parse::FILMS;
pub use settings::Film;
pub use window::Window;
