//! Estimators of what a pixel sees.
//!
//! *How to add one*: write `integrator/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line
//! to [`INTEGRATORS`] and a variant to [`AnyIntegrator`].

mod aov;
pub mod caustics;
mod depth;
mod direct;
pub mod guide;
pub mod light;
pub mod links;
mod moment;
pub mod path;
mod wavefront;

use crate::math::{DVec3, Ray};
use crate::sampler::Sampler;
use crate::scene::registry::Entry;
use crate::scene::{Features, Scene};
use crate::shape::Hit;
use crate::spectrum::{Spectrum, Wavelengths};
pub use aov::Aov;
pub use depth::Depth;
pub use direct::Direct;
pub use moment::Moment;
pub use path::Path;

/// Any integrator.
#[derive(Clone, Debug)]
pub enum AnyIntegrator {
    Path(Path),
    Direct(Direct),
    Depth(Depth),
    Aov(Box<Aov>),
    Moment(Box<Moment>),
}

macro_rules! integrators {
    ($($module:ident),* $(,)?) => {
        /// Every integrator.
        pub static INTEGRATORS: &[Entry<AnyIntegrator>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: $module::parse,
        }),*];
    };
}
integrators!(path, direct, depth, aov, moment);

impl Default for AnyIntegrator {
    fn default() -> Self {
        Self::Path(Path::default())
    }
}

/// What happened along the way, for reports.
#[derive(Clone, Debug, Default)]
pub struct Counters {
    pub rays: u64,
    /// Of these, between pixels that share and what they share; see [`path::reuse`].
    pub shared: u64,
    /// Pairs of a receiver and a source that were looked at one by one, for something rough in their group.
    pub evaluations: u64,
    /// That light paths have found for groups of pixels.
    pub light_sources: u64,
    /// Paths that reached the hard limit of vertices and were cut; see [`path::MAX_VERTICES`].
    pub cut: u64,
    /// Guided emitter samples; see [`guide`].
    pub guided: u64,
    /// The vertices of the path, for `etalon replay` only.
    pub log: Option<Vec<Event>>,
}

/// A vertex of a replayed path, as it was when the path arrived.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    pub hit: Hit,
    pub p: DVec3,
    /// What light from here on is multiplied with.
    pub throughput: Spectrum,
    /// Gathered so far, emission at this vertex included.
    pub radiance: Spectrum,
}

/// A camera ray, and what is found along it.
#[derive(Clone, Copy, Debug)]
pub struct CameraPath {
    pub ray: Ray,
    /// Comes back collapsed where a dispersive refraction has left one wavelength alone.
    pub λ: Wavelengths,
    pub sampler: Sampler,
    /// Neighbours with the same number share what they find, if the integrator has them do so.
    pub group: u32,
    pub radiance: Spectrum,
    /// Something is seen: a surface, or light from the environment. As in Mitsuba, a surface at which paths of
    /// the greatest length end is none, and `direct` does not count the environment.
    pub covered: bool,
}

/// Estimates the radiance along camera rays. How they are grouped does not change what is found.
pub type Kernel = fn(&Scene, &AnyIntegrator, &mut [CameraPath], &mut Counters);

/// A compiled kernel and what it can do.
#[derive(Debug)]
pub struct KernelEntry {
    pub features: Features,
    pub name: &'static str,
    pub run: Kernel,
}

macro_rules! kernels {
    ($($name:literal: $features:expr),* $(,)?) => {
        /// From least to most able. A scene runs the first that has all it needs; on any scene that several
        /// can run, their images are equal to the bit.
        pub static KERNELS: &[KernelEntry] = &[$(KernelEntry {
            features: Features($features),
            name: $name,
            run: radiance::<{ $features }>,
        }),*];
    };
}
kernels! {
    "plain": 0,
    "plain+environment": Features::ENVIRONMENT,
    "caustics": Features::CAUSTICS,
    "path re-use": Features::REUSE | Features::CAUSTICS | Features::ENVIRONMENT,
    "textured": Features::TEXTURED,
    "textured path re-use": Features::TEXTURED | Features::REUSE,
    "full": Features::ALL,
}

/// The least kernel that suffices.
pub fn kernel_for(features: Features) -> &'static KernelEntry {
    let enough = |k: &&KernelEntry| k.features.0 & features.0 == features.0;
    KERNELS.iter().find(enough).unwrap_or(&KERNELS[KERNELS.len() - 1])
}

fn radiance<const F: u32>(
    scene: &Scene,
    integrator: &AnyIntegrator,
    paths: &mut [CameraPath],
    counters: &mut Counters,
) {
    match integrator {
        AnyIntegrator::Path(path) => path.trace::<F>(scene, paths, counters),
        AnyIntegrator::Direct(direct) => {
            for path in paths {
                path.radiance = direct.radiance::<F>(scene, path, counters);
            }
        }
        AnyIntegrator::Depth(_) => {}
        AnyIntegrator::Aov(aov) => {
            if let Some(nested) = &aov.nested {
                radiance::<F>(scene, nested, paths, counters);
            }
        }
        AnyIntegrator::Moment(moment) => radiance::<F>(scene, &moment.nested, paths, counters),
    }
}

impl AnyIntegrator {
    pub fn name(&self) -> &'static str {
        match self {
            Self::Path(_) => path::NAME,
            Self::Direct(_) => direct::NAME,
            Self::Depth(_) => depth::NAME,
            Self::Aov(_) => aov::NAME,
            Self::Moment(_) => moment::NAME,
        }
    }

    /// The settings of the path tracer that fills the colours, if one does.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Path(path) => Some(path),
            Self::Aov(aov) => aov.nested.as_ref()?.path(),
            Self::Moment(moment) => moment.nested.path(),
            Self::Direct(_) | Self::Depth(_) => None,
        }
    }

    /// How many neighbouring pixels share what their paths find; see [`path::reuse`].
    pub fn reuse(&self) -> u32 {
        self.path().map_or(1, |path| path.reuse)
    }

    /// The settings of [`path`](Self::path), to be settled.
    pub fn path_mut(&mut self) -> Option<&mut Path> {
        match self {
            Self::Path(path) => Some(path),
            Self::Aov(aov) => aov.nested.as_mut()?.path_mut(),
            Self::Moment(moment) => moment.nested.path_mut(),
            Self::Direct(_) | Self::Depth(_) => None,
        }
    }

    /// Whether the image has colours, and not only auxiliary channels.
    pub fn has_radiance(&self) -> bool {
        match self {
            Self::Path(_) | Self::Direct(_) | Self::Moment(_) => true,
            Self::Depth(_) => false,
            Self::Aov(aov) => aov.nested.as_ref().is_some_and(|n| n.has_radiance()),
        }
    }

    /// Whether texture coordinates are needed even where no texture is.
    pub fn needs_uv(&self) -> bool {
        match self {
            Self::Aov(_) => true,
            Self::Moment(moment) => moment.nested.needs_uv(),
            Self::Path(_) | Self::Direct(_) | Self::Depth(_) => false,
        }
    }

    /// Names of the channels besides the colours.
    pub fn extra_channels(&self) -> Vec<String> {
        match self {
            Self::Path(_) | Self::Direct(_) => vec![],
            Self::Depth(_) => ["R", "G", "B"].map(String::from).to_vec(),
            Self::Aov(aov) => {
                let nested = aov.nested.as_ref().map(Self::extra_channels);
                [nested.unwrap_or_default(), aov.channels()].concat()
            }
            Self::Moment(moment) => moment.channels.clone(),
        }
    }

    /// Values of the extra channels for one camera ray.
    pub fn extra_values(&self, scene: &Scene, ray: &Ray, counters: &mut Counters, values: &mut [f64]) {
        match self {
            Self::Path(_) | Self::Direct(_) => {}
            Self::Depth(depth) => depth.values(scene, ray, counters, values),
            Self::Aov(aov) => {
                let (nested, own) = values.split_at_mut(values.len() - aov.width());
                if let Some(integrator) = &aov.nested {
                    integrator.extra_values(scene, ray, counters, nested);
                }
                aov.values(scene, ray, counters, own);
            }
            Self::Moment(moment) => {
                let nested = &mut values[..moment.nested_channels()];
                moment.nested.extra_values(scene, ray, counters, nested);
            }
        }
    }

    /// Fills the channels that follow from a sample's others, once all light has been added to those.
    #[inline]
    pub fn complete(&self, values: &mut [f64]) {
        match self {
            Self::Path(_) | Self::Direct(_) | Self::Depth(_) => {}
            Self::Aov(aov) => {
                if let Some(integrator) = &aov.nested {
                    let nested = values.len() - aov.width();
                    integrator.complete(&mut values[..nested]);
                }
            }
            Self::Moment(moment) => moment.complete(values),
        }
    }
}
