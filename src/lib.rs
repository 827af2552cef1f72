//! Etalon: a spectral path tracer that is its own measuring stick.
//!
//! What it computes is the light transport equation (Kajiya 1986)
//!
//! L(x, ωo) = Lₑ(x, ωo) + ∫ f(x, ωo, ωi) L(y(x, ωi), −ωi) |cos θi| dωi,
//!
//! for eight wavelengths at once, and of it the mean over each pixel's filter, lens and spectral response.
//!
//! - [`scene`]: from Mitsuba XML to plain arrays. [`load`] reads a scene and settles how it is to be rendered.
//! - [`shape`], [`bsdf`], [`medium`], [`phase`], [`texture`], [`volume`], [`emitter`], [`sensor`],
//!   [`sampler`]: the models, one file each.
//! - [`integrator`]: the estimators. [`integrator::path`] is the heart of the program.
//! - [`render`]: makes samples and schedules them: tiles, passes, threads, checkpoints. However the work is
//!   divided, pixels are the same; only [`render::plan`], which chooses settings by pilots, chooses which.
//! - [`film`], [`image`], [`files`]: sums that no order can change, and the files made of them.
//! - [`math`], [`spectrum`]: what all of them share.
//!
//! Models read their parameters by [`scene::params`], and [`scene`] knows them by their registries alone. Integrators
//! know the scene, and each those that stand before it in emitter sampling, links, caustics, guide, path, `volpath`.
//! [`render`] knows all, and only [`load`] knows [`render`].

/// The package's version and a hash of the sources, but for those of the command line: equal ones render the
/// same pixels.
pub const VERSION: &str = env!("ETALON_VERSION");

pub mod bsdf;
pub mod command_line;
pub mod emitter;
pub mod files;
pub mod film;
pub mod image;
pub mod integrator;
pub mod math;
pub mod medium;
mod pages;
pub mod phase;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod sensor;
pub mod shape;
pub mod spectrum;
mod spelling;
pub mod texture;
pub mod volume;

use scene::error::SceneError;
use scene::{Overrides, Scene};
use spectrum::ColorMode;
use std::path::Path;

/// Reads a scene file, and settles what it leaves open by pilots. `definitions` are values for its
/// `$parameters`.
///
/// # Errors
/// If the file, or one that it refers to, cannot be read or says what is not understood; with the place.
pub fn load(
    path: &Path,
    definitions: &[(String, String)],
    mode: ColorMode,
    overrides: &Overrides,
) -> Result<Scene, SceneError> {
    scene::read(path, definitions, mode, overrides).map(render::plan::settle)
}

/// The same from text, as if it stood in a file called `name`.
///
/// # Errors
/// As [`load`] has them.
pub fn load_text(name: &str, text: &str, mode: ColorMode) -> Result<Scene, SceneError> {
    scene::read_text(name, text, mode).map(render::plan::settle)
}
