//! Integrators: estimators of the radiance along camera rays.
//!
//! *How to add one*: write `integrator/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line
//! to [`INTEGRATORS`] and a variant to [`AnyIntegrator`], whose methods the compiler then asks for: how it finds
//! radiance, and which channels it adds. One that is around another answers by [`AnyIntegrator::nested`].

mod aov;
mod arrival;
pub mod caustics;
mod depth;
mod direct;
mod emitter_sampling;
pub mod guide;
mod lengths;
pub mod links;
mod meter;
mod mis;
mod moment;
pub mod path;
mod roulette;
mod techniques;
mod vertex;
mod volpath;
mod volpathmis;
mod wavefront;

use crate::film::Film;
use crate::image::COLOURS;
use crate::math::{DVec3, Ray};
use crate::sampler::Sampler;
pub use crate::sampler::blocks::MAX_VERTICES;
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::registry::Entry;
use crate::scene::xml::Element;
use crate::scene::{Features, Scene};
use crate::spectrum::{Spectrum, Wavelengths};
pub use aov::Aov;
pub use depth::Depth;
pub use direct::Direct;
pub use moment::Moment;
pub use path::Path;
pub use roulette::Roulette;
pub use techniques::Techniques;
pub use volpath::VolPath;

/// Any integrator.
#[derive(Clone, Debug)]
pub enum AnyIntegrator {
    Path(Path),
    Direct(Direct),
    Depth(Depth),
    VolPath(VolPath),
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
            parse: |params| {
                let integrator = $module::parse(params)?;
                ignore(params)?;
                Ok(integrator)
            },
        }),*];
    };
}
integrators!(path, direct, depth, volpath, volpathmis, aov, moment);

/// At most one nested integrator, and what begins the names of its channels: its name, or what Mitsuba calls
/// one without.
fn nested_integrator<'d>(
    params: &mut Params<'_, 'd>,
    about: &'static str,
) -> Result<Option<(&'d Element, &'d str)>, SceneError> {
    let found = params.one_nested("integrator", about, |element| element.tag == "integrator")?;
    Ok(found.map(|(element, site)| (element, site.name().unwrap_or("_arg_0"))))
}

/// Reads what every integrator of Mitsuba has and this one has not read: `hide_emitters`, if it shows no light
/// itself, and how Mitsuba divides its work.
fn ignore(params: &mut Params) -> Result<(), SceneError> {
    params.boolean("hide_emitters", false, "Mitsuba's; ignored")?;
    params.float("timeout", -1.0, "Mitsuba's; ignored")?;
    for name in ["block_size", "samples_per_pass"] {
        params.integer(name, -1, 0..=i64::from(u32::MAX), "Mitsuba's; ignored")?;
    }
    Ok(())
}

impl Default for AnyIntegrator {
    fn default() -> Self {
        Self::Path(Path::default())
    }
}

/// Counts of what was traced, for reports.
#[derive(Clone, Debug, Default)]
pub struct Counters {
    pub rays: u64,
    /// How many of the rays test receivers and sources of shared paths; see [`path::reuse`].
    pub shared: u64,
    /// Sources that light paths have found for groups of pixels.
    pub light_sources: u64,
    /// Paths that reached the hard limit of vertices and were cut; see [`MAX_VERTICES`].
    pub cut: u64,
    /// Guided emitter samples; see [`guide`].
    pub guided: u64,
    /// The vertices of the path, for `etalon replay` only.
    pub log: Option<Vec<Event>>,
}

impl Counters {
    /// Adds what other paths have counted; their logs are not kept.
    pub fn add(&mut self, other: &Self) {
        let Self { rays, shared, light_sources, cut, guided, log: _ } = other;
        self.rays += rays;
        self.shared += shared;
        self.light_sources += light_sources;
        self.cut += cut;
        self.guided += guided;
    }
}

/// A vertex of a replayed path, as it was when the path arrived.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Its distance along the ray.
    pub t: f64,
    /// The primitive that it lies on, unless it is within a medium.
    pub primitive: Option<u32>,
    pub p: DVec3,
    /// Factor of light that is found from here on.
    pub throughput: Spectrum,
    /// Radiance gathered so far, emission at this vertex included.
    pub radiance: Spectrum,
}

/// A camera ray, and what is found along it.
#[derive(Clone, Copy, Debug)]
pub struct CameraPath {
    pub ray: Ray,
    /// The wavelengths of the lanes; the kernel collapses them where dispersive refraction leaves only one.
    pub λ: Wavelengths,
    pub sampler: Sampler,
    /// Neighbours with the same number share what they find, if the integrator has them do so.
    pub group: u32,
    pub radiance: Spectrum,
    /// Something is seen: a surface, or light from the environment. As in Mitsuba, a surface at which those of `path`
    /// end for their length is none, and `direct` does not count the environment.
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
#[cfg(not(test))]
kernels! {
    "plain": 0,
    "plain+environment": Features::ENVIRONMENT,
    "caustics": Features::CAUSTICS,
    "path re-use": Features::REUSE | Features::CAUSTICS | Features::ENVIRONMENT,
    "textured": Features::TEXTURED,
    "textured path re-use": Features::TEXTURED | Features::REUSE,
    "full": Features::ALL,
}
// Unit tests need one kernel, and each takes six seconds to compile: the programs of tests/ run the others.
#[cfg(test)]
kernels! { "full": Features::ALL }

/// The least kernel that suffices.
pub fn kernel_for(features: Features) -> &'static KernelEntry {
    let enough = |k: &&KernelEntry| k.features.cover(features);
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
        AnyIntegrator::VolPath(volpath) => {
            for path in paths {
                path.radiance = volpath.radiance::<F>(scene, path, counters);
            }
        }
        AnyIntegrator::Depth(_) | AnyIntegrator::Aov(_) | AnyIntegrator::Moment(_) => {
            if let Some(nested) = integrator.nested() {
                radiance::<F>(scene, nested, paths, counters);
            }
        }
    }
}

impl AnyIntegrator {
    pub fn name(&self) -> &'static str {
        match self {
            Self::Path(_) => path::NAME,
            Self::Direct(_) => direct::NAME,
            Self::Depth(_) => depth::NAME,
            Self::VolPath(_) => volpath::NAME,
            Self::Aov(_) => aov::NAME,
            Self::Moment(_) => moment::NAME,
        }
    }

    /// The integrator that this one is around, and which finds its radiance.
    pub fn nested(&self) -> Option<&Self> {
        match self {
            Self::Aov(aov) => aov.nested.as_ref(),
            Self::Moment(moment) => Some(&moment.nested),
            Self::Path(_) | Self::Direct(_) | Self::VolPath(_) | Self::Depth(_) => None,
        }
    }

    /// The same, to be settled.
    fn nested_mut(&mut self) -> Option<&mut Self> {
        match self {
            Self::Aov(aov) => aov.nested.as_mut(),
            Self::Moment(moment) => Some(&mut moment.nested),
            Self::Path(_) | Self::Direct(_) | Self::VolPath(_) | Self::Depth(_) => None,
        }
    }

    /// The settings of the path tracer that fills the colours, if one does.
    pub fn path(&self) -> Option<&Path> {
        if let Self::Path(path) = self { Some(path) } else { self.nested()?.path() }
    }

    /// The integrator for a scene where no medium and no surface lets light straight through: there media
    /// change nothing, and `path` has more techniques.
    pub fn without_media(self) -> Self {
        match self {
            Self::VolPath(volpath) => Self::Path(volpath.without_media()),
            Self::Aov(aov) => Self::Aov(Box::new(aov.without_media())),
            Self::Moment(moment) => Self::Moment(Box::new(moment.without_media())),
            Self::Path(_) | Self::Direct(_) | Self::Depth(_) => self,
        }
    }

    /// How many neighbouring pixels share what their paths find; 1 if none do. See [`path::reuse`].
    pub fn reuse(&self) -> u32 {
        self.path().map_or(1, |path| path.reuse)
    }

    /// The settings of [`path`](Self::path), to be settled.
    pub fn path_mut(&mut self) -> Option<&mut Path> {
        if let Self::Path(path) = self { Some(path) } else { self.nested_mut()?.path_mut() }
    }

    /// Whether the image has colours, and not only auxiliary channels.
    pub fn has_radiance(&self) -> bool {
        match self {
            Self::Path(_) | Self::Direct(_) | Self::VolPath(_) => true,
            Self::Depth(_) | Self::Aov(_) | Self::Moment(_) => self.nested().is_some_and(Self::has_radiance),
        }
    }

    /// Whether texture coordinates are needed even where no texture is.
    pub fn needs_uv(&self) -> bool {
        matches!(self, Self::Aov(_)) || self.nested().is_some_and(Self::needs_uv)
    }

    /// Names of the channels of an image: R, G, B, alpha, the spectral bands, and what the integrator adds.
    pub fn channel_names(&self, film: &Film) -> Vec<String> {
        let mut names: Vec<String> = vec![];
        if self.has_radiance() {
            names.extend(COLOURS.map(String::from));
            names.extend(film.alpha.then(|| "A".to_owned()));
            names.extend(film.bands.iter().map(|band| band.channel.clone()));
        }
        names.extend(self.extra_channels());
        names
    }

    /// Names of the channels besides the colours.
    pub fn extra_channels(&self) -> Vec<String> {
        match self {
            Self::Path(_) | Self::Direct(_) | Self::VolPath(_) => vec![],
            Self::Depth(_) => COLOURS.map(String::from).to_vec(),
            Self::Aov(aov) => aov.channels(),
            Self::Moment(moment) => moment.channels.clone(),
        }
    }

    /// Values of the extra channels for one camera ray.
    pub fn extra_values(&self, scene: &Scene, ray: &Ray, counters: &mut Counters, values: &mut [f64]) {
        match self {
            Self::Path(_) | Self::Direct(_) | Self::VolPath(_) => {}
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
            Self::Path(_) | Self::Direct(_) | Self::VolPath(_) | Self::Depth(_) => {}
            Self::Aov(aov) => aov.complete(values),
            Self::Moment(moment) => moment.complete(values),
        }
    }
}
