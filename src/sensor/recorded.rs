//! What sensors have besides their optics.

use super::{AnySensor, Sensor};
use crate::film::filter::Profile;
use crate::film::filter_sampler::FilterSampler;
use crate::film::{FILMS, Film};
use crate::math::Transform;
use crate::medium::Medium;
use crate::sampler::{SAMPLERS, SamplerSettings};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::construct;
use std::sync::Arc;

/// What every sensor has.
pub struct Recorded {
    film: Film,
    sampler: SamplerSettings,
    medium: Option<Arc<Medium>>,
}

impl Recorded {
    /// A sensor with this, and with this camera or meter.
    pub fn with(self, camera: AnySensor) -> Sensor {
        Sensor { camera, film: self.film, sampler: self.sampler, medium: self.medium }
    }
}

/// The parameters that every camera has besides its optics.
pub struct Common {
    pub to_world: Transform,
    pub near: f64,
    pub far: f64,
    recorded: Recorded,
}

impl Common {
    /// A sensor with these parameters and this camera.
    pub fn with(self, camera: AnySensor) -> Sensor {
        self.recorded.with(camera)
    }

    /// Of the film, width over height.
    pub fn aspect(&self) -> f64 {
        self.recorded.film.aspect()
    }
}

pub fn common(params: &mut Params) -> Result<Common, SceneError> {
    let to_world =
        params.transform("to_world", "camera space (+z forward, +y up, +x left) to world space")?;
    let near =
        params
            .float_where("near_clip", 1e-2, "nothing nearer is seen", "a positive distance", |v| v > 0.0)?;
    let expected = "a distance beyond `near_clip`";
    let far = params.float_where("far_clip", 1e4, "nothing farther is seen", expected, |v| v > near)?;
    if far <= near {
        return Err(params.error(
            "near_clip",
            "`near_clip` is beyond `far_clip`",
            "add a `far_clip` beyond it",
        ));
    }
    Ok(Common { to_world, near, far, recorded: recorded(params, Film::default)? })
}

/// By default on this film, which is made only then: it tabulates its filter.
fn recorded(params: &mut Params, film: impl FnOnce() -> Film) -> Result<Recorded, SceneError> {
    let film = match params.object("film", "what it records on")? {
        None => film(),
        Some(element) => construct(FILMS, element, params.loader, Usage::Unbounded)?,
    };
    let sampler = match params.object("sampler", "how it is sampled")? {
        None => SamplerSettings::default(),
        Some(element) => construct(SAMPLERS, element, params.loader, Usage::Unbounded)?,
    };
    let open = params.float("shutter_open", 0.0, "Mitsuba's; nothing moves")?;
    let close = params.float("shutter_close", 0.0, "Mitsuba's; nothing moves")?;
    if close < open {
        let name = if params.has("shutter_close") { "shutter_close" } else { "shutter_open" };
        let expected = "expected `shutter_close` not to be before `shutter_open`";
        return Err(params.error(name, "the shutter closes before it opens", expected));
    }
    let medium = params.any_medium("what it is in, for `volpath`")?;
    Ok(Recorded { film, sampler, medium })
}

/// What a meter records on. All of its one pixel is alike, so the filter is a box.
pub fn one_pixel(params: &mut Params) -> Result<Recorded, SceneError> {
    const SIZE: (u32, u32) = (1, 1);
    let mut recorded = recorded(params, || Film::new(SIZE, Profile::Box))?;
    if recorded.film.size != SIZE {
        let (width, height) = recorded.film.size;
        let film = params.element.children.iter().find(|child| child.tag == "film");
        return Err(SceneError::at(
            film.map_or(&params.element.span, |film| &film.span),
            format!("a film of {width} × {height} pixels, and a meter measures one number"),
            "expected a film of 1 × 1 pixels",
        ));
    }
    recorded.film.filter = FilterSampler::new(Profile::Box);
    Ok(recorded)
}
