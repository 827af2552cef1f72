//! Cameras: from a place on the film and one on the lens to a ray.
//!
//! *How to add one*: write `sensor/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line to [`SENSORS`]
//! and a variant to [`AnySensor`].

mod orthographic;
mod perspective;
mod thinlens;

use crate::film::{FILMS, Film};
use crate::math::{DVec2, DVec3, Ray, Transform};
use crate::sampler::{SAMPLERS, SamplerSettings};
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::{Entry, construct};
use crate::scene::xml::Element;
pub use orthographic::Orthographic;
pub use perspective::Perspective;
pub use thinlens::ThinLens;

/// Any camera.
#[derive(Clone, Debug)]
pub enum AnySensor {
    Perspective(Perspective),
    ThinLens(ThinLens),
    Orthographic(Orthographic),
}

/// A camera with what it records on and how it is sampled.
#[derive(Clone, Debug)]
pub struct Sensor {
    pub camera: AnySensor,
    pub film: Film,
    pub sampler: SamplerSettings,
}

macro_rules! sensors {
    ($($module:ident),* $(,)?) => {
        /// Every camera.
        pub static SENSORS: &[Entry<Sensor>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: $module::parse,
        }),*];
    };
}
sensors!(perspective, thinlens, orthographic);

impl Sensor {
    pub fn parse<'d>(element: &'d Element, loader: &Loader<'d>) -> Result<Self, SceneError> {
        construct(SENSORS, element, loader, Usage::Unbounded)
    }
}

impl AnySensor {
    /// The ray through a place on the film (0 to 1 from the upper left) and a place on the unit square of the lens.
    #[inline]
    pub fn ray(&self, film: DVec2, lens: DVec2) -> Ray {
        match self {
            Self::Perspective(camera) => camera.ray(film),
            Self::ThinLens(camera) => camera.ray(film, lens),
            Self::Orthographic(camera) => camera.ray(film),
        }
    }

    pub fn name(&self) -> &'static str {
        match self {
            Self::Perspective(_) => perspective::NAME,
            Self::ThinLens(_) => thinlens::NAME,
            Self::Orthographic(_) => orthographic::NAME,
        }
    }
}

/// What every camera has besides its optics.
struct Common {
    to_world: Transform,
    near: f64,
    far: f64,
    film: Film,
    sampler: SamplerSettings,
}

fn common(params: &mut Params) -> Result<Common, SceneError> {
    let to_world =
        params.transform("to_world", "camera space (+z forward, +y up, +x left) to world space")?;
    let near =
        params
            .float_where("near_clip", 1e-2, "nothing nearer is seen", "a positive distance", |v| v > 0.0)?;
    let expected = "a distance beyond `near_clip`";
    let far = params.float_where("far_clip", 1e4, "nothing farther is seen", expected, |v| v > near)?;
    let film = match params.object("film", "what the camera records on")? {
        None => Film::default(),
        Some(element) => construct(FILMS, element, params.loader, Usage::Unbounded)?,
    };
    let sampler = match params.object("sampler", "how the camera is sampled")? {
        None => SamplerSettings::default(),
        Some(element) => construct(SAMPLERS, element, params.loader, Usage::Unbounded)?,
    };
    params.float("shutter_open", 0.0, "Mitsuba's; nothing moves")?;
    params.float("shutter_close", 0.0, "Mitsuba's; nothing moves")?;
    Ok(Common { to_world, near, far, film, sampler })
}

/// tan of half the horizontal field of view, from `fov` and `fov_axis` or from `focal_length`.
fn half_width(params: &mut Params, aspect: f64) -> Result<f64, SceneError> {
    let axes = ["x", "y", "diagonal", "smaller", "larger"];
    let expected = "degrees above 0 and below 180";
    let given = params.has("fov");
    let fov =
        params.float_where("fov", 50.0, "field of view in degrees", expected, |v| v > 0.0 && v < 180.0)?;
    let axis = params.choice("fov_axis", &axes, "the axis that `fov` is along")?;
    let focal = params.string("focal_length", "instead of `fov`: of a lens for 35 mm film, such as 50mm")?;
    let (half, axis) = match focal {
        Some(place) if given => {
            let message = "both `fov` and `focal_length`";
            return Err(SceneError::at(&place.value_span, message, "expected one of them"));
        }
        _ if given => (crate::math::transform::half_width(fov), axis),
        _ => {
            let length = focal.map_or("50mm", |a| a.value.as_str()).trim().trim_end_matches("mm");
            let length = crate::scene::params::number(length).filter(|v| *v > 0.0);
            let length = length
                .ok_or_else(|| params.error("focal_length", "no focal length", "expected such as 50mm"))?;
            // Half the diagonal of a 36 mm × 24 mm frame.
            (0.5 * (36.0f64 * 36.0 + 24.0 * 24.0).sqrt() / length, "diagonal")
        }
    };
    Ok(match axis {
        "y" => half * aspect,
        "smaller" if aspect > 1.0 => half * aspect,
        "larger" if aspect <= 1.0 => half * aspect,
        "diagonal" => half / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
        _ => half,
    })
}

/// Refuses a camera whose transform scales; distances along its rays would not be distances in the world.
fn require_rigid(params: &Params, to_world: &Transform) -> Result<(), SceneError> {
    /// Matrices written with a few decimals are meant as rotations; Mitsuba's tolerance.
    const TOLERANCE: f64 = 1e-3;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis));
    let scaled = axes.iter().any(|axis| (axis.length_squared() - 1.0).abs() > TOLERANCE);
    if scaled {
        return Err(params.error(
            "to_world",
            "a camera cannot be scaled",
            "expected rotation and translation",
        ));
    }
    Ok(())
}
