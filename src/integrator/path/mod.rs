//! Unidirectional path tracing with direct light by multiple importance sampling.

mod chain;
mod escapes;
mod gather;
pub mod reuse;
mod scatter;
mod shadows;
mod step;
mod stream;

use super::AnyIntegrator;
use super::caustics::DEFAULT_RATIO;
use super::lengths::Lengths;
use super::links::LinkPolicy;
use super::roulette::Roulette;
use crate::sampler::blocks::{MOST_EMITTER_SAMPLES, MOST_SHARED_LIGHT_PATHS};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use reuse::AUTO;

pub const NAME: &str = "path";
pub const ABOUT: &str = "Path tracing: all light that a camera path can find, unbiased.";
pub const EXAMPLES: &[&str] = &[
    r#"<integrator type="path"/>"#,
    r#"<integrator type="path"><integer name="max_depth" value="8"/><integer name="rr_depth" value="5"/>
        <integer name="emitter_samples" value="4"/></integrator>"#,
];

/// Up to this many emitters, one number both chooses the emitter and places the sample on it: the choice
/// takes four of its 32 bits.
const FEW_EMITTERS: usize = 16;

/// The settings, with Mitsuba's meaning of each.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    pub lengths: Lengths,
    /// Which camera paths go through Russian roulette: those of `lengths`, unless a pilot decides.
    pub roulette: Roulette,
    /// Emitter samples at every vertex; Mitsuba takes one.
    pub emitter_samples: u32,
    /// Emitter samples at vertices that the camera sees, straight or by mirrors, smooth glass and smooth
    /// coats.
    pub first_emitter_samples: u32,
    /// Light paths per camera path, where there are caustics; see [`caustics`](super::caustics).
    pub light_paths: f64,
    /// How many neighbouring pixels share what their paths find; see [`reuse`].
    pub reuse: u32,
    /// Light paths of each group of pixels that share; see [`reuse`].
    pub shared_light_paths: u32,
    /// Where emitters are sampled through glass and by mirrors; see [`links`](super::links).
    pub links: LinkPolicy,
    /// Which of these settings are only where pilots begin.
    pub open: Open,
}

/// Which settings the scene's file leaves open, for [`crate::render::plan`] to choose. `links` is open where it is
/// [`LinkPolicy::Auto`].
#[derive(Clone, Copy, Debug)]
pub struct Open {
    pub light_paths: bool,
    pub reuse: bool,
    /// If pixels share.
    pub shared_light_paths: bool,
    /// If `reuse` is open.
    pub first_emitter_samples: bool,
    /// If `reuse` is open.
    pub roulette: bool,
}

/// Valid numbers of light paths per camera path.
pub const RATIOS: std::ops::RangeInclusive<f64> = 0.0..=64.0;

impl Default for Path {
    fn default() -> Self {
        Self::of(Lengths::default())
    }
}

impl Path {
    /// With all other settings as if none was given.
    pub fn of(lengths: Lengths) -> Self {
        Self {
            lengths,
            roulette: Roulette::after(lengths.rr_depth),
            emitter_samples: 1,
            first_emitter_samples: 1,
            light_paths: DEFAULT_RATIO,
            reuse: 1,
            shared_light_paths: 0,
            links: LinkPolicy::Auto,
            open: Open {
                light_paths: true,
                reuse: false,
                shared_light_paths: true,
                first_emitter_samples: true,
                roulette: true,
            },
        }
    }
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    let begins = params.has("rr_depth");
    let lengths = Lengths::parse(params)?;
    let about = "emitter samples at every vertex (an extension)";
    let emitter_samples = params.count("emitter_samples", 1, 1..=MOST_EMITTER_SAMPLES, about)?;
    let about = "emitter samples at vertices that the camera sees, straight or by mirrors, smooth glass and smooth coats: by default `emitter_samples`, or, where a pilot decides on `reuse`, what it finds best (an extension)";
    let first = params.count("first_emitter_samples", AUTO, 1..=MOST_EMITTER_SAMPLES, about)?;
    let about =
        "light paths to a camera path, where there are caustics; 0 leaves all to camera paths (an extension)";
    let light_paths = params.optional_float("light_paths", about)?;
    if light_paths.is_some_and(|share| !RATIOS.contains(&share)) {
        let help = format!("expected {} to {}", RATIOS.start(), RATIOS.end());
        return Err(params.error("light_paths", "no such share", help));
    }
    let about = "neighbouring pixels that share what their paths find: a power of two up to 64, or 0 for a pilot to decide (an extension)";
    let reuse = params.count("reuse", 1, 0..=64, about)?;
    if reuse != AUTO && !reuse::PIXELS.contains(&reuse) {
        return Err(params.error(
            "reuse",
            "no such number of pixels",
            "expected a power of two up to 64, or 0",
        ));
    }
    let about = "light paths of each group of pixels that share: no more than there are pixels; −1 means none, or, where a pilot decides on `reuse`, what it finds best (an extension)";
    let shared_light_paths =
        params.integer("shared_light_paths", -1, -1..=i64::from(MOST_SHARED_LIGHT_PATHS), about)?;
    // The range bounds what a pilot decides about.
    let too_many = reuse != AUTO && shared_light_paths > i64::from(reuse);
    if too_many || reuse == 1 && shared_light_paths > 0 {
        let message = format!("{shared_light_paths} light paths for {reuse} pixels that share them");
        let help = match reuse {
            1 => "expected `reuse` as well: as many pixels or more, or a pilot that decides (0 in a scene, `auto` on the command line)".to_owned(),
            _ => format!("expected at most {reuse}, or a larger `reuse`"),
        };
        return Err(params.error("shared_light_paths", message, help));
    }
    let about = "where emitters are sampled through glass and by mirrors; `unaided`: where light paths cannot help; `guided`: there, along ways that light paths have shown (an extension)";
    let links = params.choice_of("links", &LinkPolicy::ALL, about)?;
    let open = Open {
        light_paths: light_paths.is_none(),
        reuse: reuse == AUTO,
        shared_light_paths: shared_light_paths < 0,
        first_emitter_samples: first == AUTO,
        roulette: !begins,
    };
    Ok(AnyIntegrator::Path(Path {
        emitter_samples,
        first_emitter_samples: if open.first_emitter_samples { emitter_samples } else { first },
        light_paths: light_paths.unwrap_or(DEFAULT_RATIO),
        reuse: if open.reuse { 1 } else { reuse },
        shared_light_paths: u32::try_from(shared_light_paths).unwrap_or(0),
        links,
        open,
        ..Path::of(lengths)
    }))
}

#[cfg(test)]
mod tests;
