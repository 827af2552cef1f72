//! Sensors: from a place on the film and one on the lens to a ray. Cameras make images; meters measure one number.
//!
//! *How to add one*: write `sensor/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line to
//! [`SENSORS`] and a variant to [`AnySensor`].

#[cfg(test)]
mod contract;
mod distant;
mod orthographic;
mod perspective;
mod radiancemeter;
mod thinlens;

use crate::film::filter::Profile;
use crate::film::filter_sampler::FilterSampler;
use crate::film::{FILMS, Film};
use crate::math::{Ball, Bounds, DVec2, DVec3, Ray, Transform};
use crate::medium::Medium;
use crate::sampler::{SAMPLERS, SamplerSettings};
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::{Entry, construct};
use crate::scene::xml::Element;
use crate::spelling::shortened;
pub use distant::Distant;
use glam::DVec4;
pub use orthographic::Orthographic;
pub use perspective::Perspective;
pub use radiancemeter::RadianceMeter;
use std::sync::Arc;
pub use thinlens::ThinLens;

/// Any sensor.
#[derive(Clone, Debug)]
pub enum AnySensor {
    Perspective(Perspective),
    ThinLens(ThinLens),
    Orthographic(Orthographic),
    RadianceMeter(RadianceMeter),
    Distant(Distant),
}

/// A point as a camera sees it.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Unit direction from the point to the lens, world space.
    pub towards: DVec3,
    /// Distance to the lens, over which the shadow ray must be unoccluded.
    pub distance: f64,
    /// The place on the film, 0 to 1 from the upper left where it is on it.
    pub film: DVec2,
    /// The part of the film that a unit of area about the point, across the line of sight, fills.
    pub per_area: f64,
}

/// A camera or a meter with what it records on and how it is sampled.
#[derive(Clone, Debug)]
pub struct Sensor {
    pub camera: AnySensor,
    pub film: Film,
    pub sampler: SamplerSettings,
    /// What it is in.
    pub medium: Option<Arc<Medium>>,
}

macro_rules! sensors {
    ($($module:ident),* $(,)?) => {
        /// Every sensor.
        pub static SENSORS: &[Entry<Sensor>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: $module::parse,
        }),*];
    };
}
sensors!(perspective, thinlens, orthographic, radiancemeter, distant);

impl Sensor {
    pub fn parse<'d>(element: &'d Element, loader: &Loader<'d>) -> Result<Self, SceneError> {
        construct(SENSORS, element, loader, Usage::Unbounded)
    }
}

impl AnySensor {
    /// The ray through a place on the film (0 to 1 from the upper left) and a place on the unit square of the
    /// lens.
    #[inline]
    pub fn ray(&self, film: DVec2, lens: DVec2) -> Ray {
        match self {
            Self::Perspective(camera) => camera.ray(film),
            Self::ThinLens(camera) => camera.ray(film, lens),
            Self::Orthographic(camera) => camera.ray(film),
            Self::RadianceMeter(meter) => meter.ray(),
            Self::Distant(meter) => meter.ray(lens),
        }
    }

    /// Whether the place on the lens matters.
    pub fn has_lens(&self) -> bool {
        match self {
            Self::ThinLens(_) => true,
            Self::Distant(meter) => meter.has_lens(),
            Self::Perspective(_) | Self::Orthographic(_) | Self::RadianceMeter(_) => false,
        }
    }

    /// Whether it makes an image: then light paths can be connected with it, and what is seen has a place on the film.
    pub fn has_image(&self) -> bool {
        match self {
            Self::Perspective(_) | Self::ThinLens(_) | Self::Orthographic(_) => true,
            Self::RadianceMeter(_) | Self::Distant(_) => false,
        }
    }

    /// Tells the box around the scene, which may be empty.
    pub fn look_at(&mut self, bounds: Bounds) {
        if let Self::Distant(meter) = self
            && bounds.0.x <= bounds.1.x
        {
            meter.look_at(Ball::of_box(bounds));
        }
    }

    /// How a point in the world is seen through a place on the unit square of the lens, if it is not
    /// occluded. `None` for what lies behind the camera or beyond its clipping distances, and of what makes no image.
    #[inline]
    pub fn connect(&self, p: DVec3, lens: DVec2) -> Option<View> {
        match self {
            Self::Perspective(camera) => camera.connect(p),
            Self::ThinLens(camera) => camera.connect(p, lens),
            Self::Orthographic(camera) => camera.connect(p),
            Self::RadianceMeter(_) | Self::Distant(_) => None,
        }
    }

    /// [`View::per_area`] at the point `p` of a camera ray; 0 of what makes no image.
    pub fn seen_per_area(&self, ray: &Ray, p: DVec3) -> f64 {
        match self {
            Self::Perspective(camera) => camera.foreshortening.per_area(ray.direction, p),
            Self::ThinLens(camera) => camera.foreshortening.per_area(ray.direction, p),
            Self::Orthographic(camera) => camera.per_area(),
            Self::RadianceMeter(_) | Self::Distant(_) => 0.0,
        }
    }

    pub fn name(&self) -> &'static str {
        match self {
            Self::Perspective(_) => perspective::NAME,
            Self::ThinLens(_) => thinlens::NAME,
            Self::Orthographic(_) => orthographic::NAME,
            Self::RadianceMeter(_) => radiancemeter::NAME,
            Self::Distant(_) => distant::NAME,
        }
    }
}

/// How much of the film an area fills in front of a camera whose film is an image of half size `half` at
/// depth 1.
///
/// A place x of the film is seen along A d, d = (x, y, 1) less something that does not depend on x, so the
/// film's area dx fills the solid angle |det A| dx / |A d|³. With ω = A d / |A d| the third component of A⁻¹ω
/// is 1 / |A d|, and a point at depth z lies at the distance z |A d|. Together, dx/dA across the line of
/// sight is 1 / (|det A| (A⁻¹ω)₃ z²).
#[derive(Clone, Copy, Debug)]
struct Foreshortening {
    /// The third row of A⁻¹: depth from a point, and from a direction.
    depth: DVec4,
    /// 1 / (|det A| · area of the film).
    scale: f64,
}

impl Foreshortening {
    fn new(to_world: &Transform, half: DVec2) -> Self {
        let determinant = to_world.matrix.determinant().abs();
        Self { depth: to_world.inverse.row(2), scale: 1.0 / (4.0 * half.x * half.y * determinant) }
    }

    /// [`View::per_area`] at the point `p` along ω from the camera.
    #[inline]
    fn per_area(&self, w: DVec3, p: DVec3) -> f64 {
        let depth = self.depth.truncate().dot(p) + self.depth.w;
        self.scale / (self.depth.truncate().dot(w) * depth * depth)
    }
}

/// What every sensor has.
struct Recorded {
    film: Film,
    sampler: SamplerSettings,
    medium: Option<Arc<Medium>>,
}

impl Recorded {
    /// A sensor with this, and with this camera or meter.
    fn with(self, camera: AnySensor) -> Sensor {
        Sensor { camera, film: self.film, sampler: self.sampler, medium: self.medium }
    }
}

/// The parameters that every camera has besides its optics.
struct Common {
    to_world: Transform,
    near: f64,
    far: f64,
    recorded: Recorded,
}

impl Common {
    /// A sensor with these parameters and this camera.
    fn with(self, camera: AnySensor) -> Sensor {
        self.recorded.with(camera)
    }

    /// Of the film, width over height.
    fn aspect(&self) -> f64 {
        self.recorded.film.aspect()
    }
}

fn common(params: &mut Params) -> Result<Common, SceneError> {
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
fn one_pixel(params: &mut Params) -> Result<Recorded, SceneError> {
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

/// tan of half the horizontal field of view of a picture of this width over height, from `fov` and `fov_axis`
/// or from `focal_length`.
pub fn half_width(params: &mut Params, aspect: f64) -> Result<f64, SceneError> {
    let axes = ["x", "y", "diagonal", "smaller", "larger"];
    let expected = "degrees above 0 and below 180";
    let about = "field of view in degrees; without it `focal_length` holds";
    let fov = params.optional_float_where("fov", about, expected, |v| v > 0.0 && v < 180.0)?;
    let axis = params.word("fov_axis", &axes, "the axis that `fov` is along")?;
    let about = "instead of `fov`: of a lens for 35 mm film; without either it is 50mm";
    let focal = params.string("focal_length", about)?;
    if fov.is_none() && params.has("fov_axis") {
        let message = "`fov_axis` without `fov`: a `focal_length` is along the diagonal";
        return Err(params.error("fov_axis", message, "expected it beside `fov` only"));
    }
    let (half, axis) = match (focal, fov) {
        (Some(place), Some(_)) => {
            let message = "both `fov` and `focal_length`";
            return Err(SceneError::at(&place.value_span, message, "expected one of them"));
        }
        (None, Some(fov)) => (crate::math::transform::half_width(fov), axis),
        (_, None) => {
            let text = focal.map_or("50mm", |a| a.value.as_str()).trim();
            let length = text.strip_suffix("mm").unwrap_or(text);
            let length = crate::scene::params::number(length).filter(|v| *v > 0.0);
            let length = length.ok_or_else(|| {
                let message = format!("`{}` is no focal length", shortened(text));
                params.error("focal_length", message, "expected millimetres, such as 50mm")
            })?;
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

/// Refuses a camera, or another thing of this name, whose transform scales; distances along its rays would not
/// be distances in the world.
pub fn require_rigid(params: &Params, to_world: &Transform, name: &str) -> Result<(), SceneError> {
    /// Matrices written with a few decimals are meant as rotations; Mitsuba's tolerance.
    const TOLERANCE: f64 = 1e-3;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis));
    let scaled = axes.iter().any(|axis| (axis.length_squared() - 1.0).abs() > TOLERANCE);
    if scaled {
        return Err(params.error(
            "to_world",
            format!("{name} cannot be scaled"),
            "expected rotation and translation",
        ));
    }
    Ok(())
}
