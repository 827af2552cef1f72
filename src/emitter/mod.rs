//! Emitters.
//!
//! *How to add one*: write `emitter/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line to
//! [`EMITTERS`] and a variant to [`AnyEmitter`], whose methods the compiler then asks for: how it is sampled, what it
//! shines where it is met, with which density that would have been sampled, and what may be expected of it.

pub(crate) mod area;
mod constant;
mod directional;
mod envmap;
pub mod gather_point;
mod point;
mod projector;
pub mod select;
mod spot;
pub mod tree;

use crate::math::cone::Cone;
use crate::math::{DVec2, DVec3, Ray};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::registry::Entry;
use crate::shape::{Geometry, SurfacePoint};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::AnyTexture;
pub use area::Area;
pub use constant::Constant;
pub use directional::Directional;
pub use envmap::{EnvironmentMap, MapPlace};
pub use gather_point::{GatherPoint, Gathers};
pub use point::Point;
pub use projector::Projector;
pub use select::{Choice, Emitters};
use select::{Distant, Expected};
pub use spot::Spot;
use std::f64::consts::PI;
use tree::Cluster;

/// How much of light that is the same on all sides is sought by emitter samples rather than left to
/// scattering, where there are other emitters.
const OF_EVEN_LIGHT: f64 = 0.25;

/// A point on the surface of an emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmitterPoint {
    /// The emitter's index in the scene's list.
    pub emitter: usize,
    /// The point (world).
    pub p: DVec3,
    /// The surface's normal there (world, unit length).
    pub n: DVec3,
}

/// Any emitter.
#[derive(Debug)]
pub enum AnyEmitter {
    Area(Area),
    Point(Point),
    Spot(Box<Spot>),
    Projector(Box<Projector>),
    Directional(Directional),
    Constant(Constant),
    Envmap(Box<EnvironmentMap>),
}

macro_rules! emitters {
    ($($module:ident),* $(,)?) => {
        /// Every emitter.
        pub static EMITTERS: &[Entry<AnyEmitter>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: |params| {
                params.float("sampling_weight", 1.0, "Mitsuba's; ignored, for emitters are chosen by what they may bring")?;
                params.any_medium("Mitsuba's, what the emitter is in; ignored, for paths begin at the camera")?;
                $module::parse(params)
            },
        }),*];
    };
}
emitters!(area, point, spot, projector, directional, constant, envmap);

/// Refuses a texture where there is no surface to have a place on; `expected` says what may stand there.
fn require_constant(
    params: &Params,
    name: &str,
    texture: &AnyTexture,
    expected: &str,
) -> Result<(), SceneError> {
    if !texture.varies() {
        return Ok(());
    }
    let message = format!("the {name} of this emitter cannot be textured");
    Err(params.error(name, message, expected))
}

/// Light that arrives at a point from a sampled direction, if it is not occluded.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// Unit direction towards the light, world space.
    pub wi: DVec3,
    /// Distance over which the shadow ray must be unoccluded; infinite for light from outside the scene.
    pub distance: f64,
    /// Radiance in W·m⁻²·sr⁻¹·nm⁻¹; for a delta emitter the irradiance on a plane facing it.
    pub radiance: Radiance,
    /// Density of `wi` in sr⁻¹; 1 for a delta emitter.
    pub pdf: f64,
    /// Whether no other technique can find this direction.
    pub delta: bool,
    /// Unit normal (world) of the surface that emits it, on the side that emits; zero if no surface does.
    pub n: DVec3,
}

/// Radiance that is known, or a place in the environment map: looking there waits for memory, in vain
/// if the place is not seen.
#[derive(Clone, Copy, Debug)]
pub enum Radiance {
    Known(Spectrum),
    Mapped(MapPlace),
}

/// A direction out of the scene.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Unit, world.
    pub direction: DVec3,
    /// Where an environment map has it.
    pub place: Option<MapPlace>,
}

impl AnyEmitter {
    /// A direction from which this emitter may light a surface at `p` that gathers light about `n` (world,
    /// unit): from no more than the hemisphere, by the cosine; or from everywhere if `n` is zero.
    #[inline(always)]
    pub fn sample(
        &self,
        shape: Option<&Geometry>,
        p: DVec3,
        n: DVec3,
        u: DVec2,
        λ: &Wavelengths,
    ) -> Option<DirectSample> {
        match (self, shape) {
            (Self::Area(area), Some(shape)) => area.sample(shape, p, u, λ),
            (Self::Area(_), None) => None,
            (Self::Point(point), _) => point.sample(p, λ),
            (Self::Spot(spot), _) => spot.sample(p, λ),
            (Self::Projector(projector), _) => projector.sample(p, λ),
            (Self::Directional(directional), _) => directional.sample(λ),
            (Self::Constant(constant), _) => constant.sample(n, u, λ),
            (Self::Envmap(map), _) => map.sample(n, u),
        }
    }

    /// Radiance that leaves a surface point towards ω (unit, world).
    #[inline]
    pub fn surface_radiance(&self, point: &SurfacePoint, w: DVec3, λ: &Wavelengths) -> Spectrum {
        match self {
            Self::Area(area) => area.radiance(point, w, λ),
            Self::Point(_) | Self::Spot(_) | Self::Projector(_) => Spectrum::ZERO,
            Self::Directional(_) | Self::Constant(_) | Self::Envmap(_) => Spectrum::ZERO,
        }
    }

    /// Density with which [`AnyEmitter::sample`] makes the direction of a ray that met the emitting shape.
    #[inline]
    pub fn surface_pdf(&self, shape: &Geometry, ray: &Ray, t: f64, point: &SurfacePoint) -> f64 {
        match self {
            Self::Area(area) => area.pdf(shape, ray, t, point),
            Self::Point(_) | Self::Spot(_) | Self::Projector(_) => 0.0,
            Self::Directional(_) | Self::Constant(_) | Self::Envmap(_) => 0.0,
        }
    }

    /// What is to be seen in direction ω (unit, world) of a ray that leaves the scene.
    #[inline]
    pub fn view(&self, direction: DVec3) -> View {
        let place = match self {
            Self::Envmap(map) => Some(map.place(direction)),
            Self::Area(_) | Self::Point(_) | Self::Spot(_) | Self::Projector(_) => None,
            Self::Directional(_) | Self::Constant(_) => None,
        };
        View { direction, place }
    }

    /// Radiance from outside the scene; `None` if it does not surround the scene.
    #[inline]
    pub fn distant_radiance(&self, view: &View, λ: &Wavelengths) -> Option<Spectrum> {
        match (self, &view.place) {
            (Self::Constant(constant), _) => Some(constant.radiance(λ)),
            (Self::Envmap(map), Some(place)) => Some(map.radiance(place, λ)),
            (Self::Envmap(_), None) => None,
            (
                Self::Area(_) | Self::Point(_) | Self::Spot(_) | Self::Projector(_) | Self::Directional(_),
                _,
            ) => None,
        }
    }

    /// The density with which [`AnyEmitter::sample`] makes the direction of a view out of the scene, for a
    /// surface that gathers light about `n`.
    #[inline]
    pub fn distant_pdf(&self, view: &View, n: DVec3) -> f64 {
        match (self, &view.place) {
            (Self::Constant(_), _) => Constant::pdf(view.direction, n),
            (Self::Envmap(map), Some(place)) => map.pdf(n, place),
            (Self::Envmap(_), None) => 0.0,
            (
                Self::Area(_) | Self::Point(_) | Self::Spot(_) | Self::Projector(_) | Self::Directional(_),
                _,
            ) => 0.0,
        }
    }

    /// What may be expected of it, whoever gathers its light. Light that is much the same on all sides counts
    /// little, for scattering finds it.
    pub fn expected(&self, shape: Option<&Geometry>) -> Expected {
        let near = |bounds, (normals, cos_beyond), intensity| {
            Expected::Near(Cluster { bounds, normals, cos_beyond, intensity })
        };
        let far = |irradiance, towards| Expected::Far(Distant { irradiance, towards });
        match (self, shape) {
            (Self::Area(area), Some(shape)) => {
                let normals = shape.normals();
                near(shape.bounds(), (normals, 0.0), area.intensity(shape, normals))
            }
            // Without a surface there is no light.
            (Self::Area(_), None) => far(0.0, DVec3::ZERO),
            (Self::Point(point), _) => {
                near((point.place(), point.place()), (Cone::EVERYWHERE, 0.0), point.intensity())
            }
            (Self::Spot(spot), _) => near((spot.place(), spot.place()), spot.cone(), spot.intensity()),
            (Self::Projector(projector), _) => {
                near((projector.place(), projector.place()), projector.cone(), projector.intensity())
            }
            (Self::Directional(directional), _) => far(directional.irradiance(), directional.towards()),
            (Self::Constant(constant), _) => far(PI * constant.sought(), DVec3::ZERO),
            (Self::Envmap(map), _) => far(PI * map.sought(), DVec3::ZERO),
        }
    }

    /// Whether it surrounds the scene.
    pub fn is_environment(&self) -> bool {
        match self {
            Self::Constant(_) | Self::Envmap(_) => true,
            Self::Area(_) | Self::Point(_) | Self::Spot(_) | Self::Projector(_) | Self::Directional(_) => {
                false
            }
        }
    }

    /// Whether it needs texture coordinates.
    pub fn varies(&self) -> bool {
        match self {
            Self::Area(area) => area.varies(),
            Self::Point(_) | Self::Spot(_) | Self::Projector(_) => false,
            Self::Directional(_) | Self::Constant(_) | Self::Envmap(_) => false,
        }
    }

    /// The name of its model in scene files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Area(_) => area::NAME,
            Self::Point(_) => point::NAME,
            Self::Spot(_) => spot::NAME,
            Self::Projector(_) => projector::NAME,
            Self::Directional(_) => directional::NAME,
            Self::Constant(_) => constant::NAME,
            Self::Envmap(_) => envmap::NAME,
        }
    }
}
