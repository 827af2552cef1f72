//! A scene: plain arrays of everything that a ray can meet and of all emitters, read from Mitsuba 3 XML.
//!
//! Reading has three stages. [`xml`] makes a tree of elements whose every piece knows its place in the file;
//! the models read their own parameters from it through [`params`]; `build` puts what they made into arrays.

mod build;
pub mod catalogue;
mod encoding;
pub mod error;
mod hash;
pub mod instances;
mod lamps;
pub mod loader;
mod objects;
mod overrides;
mod owners;
pub mod params;
pub mod registry;
pub mod spectrum;
pub mod transform;
#[cfg(test)]
pub(crate) mod trial;
mod upgrade;
pub mod xml;

use crate::bsdf::{AnyMaterial, Traits};
use crate::emitter::Emitters;
use crate::integrator::AnyIntegrator;
use crate::integrator::caustics::Caustics;
use crate::integrator::guide::Guide;
use crate::integrator::links::Links;
use crate::integrator::path::reuse::LightSources;
use crate::math::{DVec3, Frame, Ray};
use crate::medium::Medium;
use crate::sensor::Sensor;
use crate::shape::accel::Accel;
use crate::shape::{Geometry, Hit, Mesh, SurfacePoint};
use crate::spectrum::ColorMode;
pub use build::load;
pub use build::load_text;
use instances::Instances;
use owners::Owners;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// A surface: its geometry, what it is made of and what it emits.
pub struct Shape {
    pub geometry: Geometry,
    /// The number of its first primitive, counted over the scene.
    pub first_primitive: u32,
    /// Materials by side: front, back.
    pub sides: [Side; 2],
    /// Index of its emitter in the scene's list, if it emits.
    pub emitter: Option<u32>,
    /// The media on its two sides, if the file names one; else it parts nothing.
    pub interface: Option<Box<Interface>>,
}

impl Shape {
    /// The side that faces a direction, from the cosine between the direction and the shading normal.
    #[inline]
    pub fn side_towards(&self, cos: f64) -> &Side {
        &self.sides[usize::from(cos < 0.0)]
    }

    /// Whether light passes it only by refraction, on both sides.
    pub fn refracts(&self) -> bool {
        self.sides.iter().all(|side| side.traits.refracts)
    }

    /// Whether a side of it reflects like a mirror and in no other way.
    pub fn mirrors(&self) -> bool {
        self.sides.iter().any(|side| side.traits.mirrors)
    }
}

/// The media that a surface parts.
#[derive(Clone, Debug)]
pub struct Interface {
    /// What is behind it, against its normal.
    pub interior: Option<Arc<Medium>>,
    /// What is before it.
    pub exterior: Option<Arc<Medium>>,
}

impl Interface {
    /// The medium that a direction leads into, given its cosine with the surface's normal.
    #[inline]
    pub fn towards(&self, cos: f64) -> Option<&Medium> {
        if cos > 0.0 { self.exterior.as_deref() } else { self.interior.as_deref() }
    }
}

/// The material of one side of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    /// Index of the material.
    pub material: u32,
    /// Whether the material is seen as if from its front: the local frame is turned around.
    pub turned: bool,
    pub traits: Traits,
}

impl Side {
    /// The frame of the material at a point: about the shading normal, and upside down on a turned side, where
    /// it is left-handed.
    #[inline(always)]
    pub fn frame<const F: u32>(&self, point: &SurfacePoint) -> Frame {
        let frame = point.frame(F & Features::ANISOTROPY != 0 && self.traits.anisotropic);
        Frame { n: if self.turned { -frame.n } else { frame.n }, ..frame }
    }
}

/// What a command line overrides of the scene file.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Name of an integrator, which has its default settings.
    pub integrator: Option<String>,
    /// Edges of the longest path; −1 means no limit.
    pub max_depth: Option<i64>,
    /// Which of the scene's sensors, counted from 0, instead of the first.
    pub sensor: Option<usize>,
    /// Film size; the crop window becomes the whole film.
    pub size: Option<(u32, u32)>,
    pub seed: Option<u32>,
    /// Name of a sampler.
    pub sampler: Option<String>,
    /// Light paths per camera path.
    pub light_paths: Option<f64>,
    /// Number of pixels that share what their paths find.
    pub reuse: Option<u32>,
    /// Light paths per group of pixels that share.
    pub shared_light_paths: Option<u32>,
    /// At which vertices emitters are sampled through glass and by mirrors.
    pub links: Option<String>,
}

/// Everything that a render needs.
pub struct Scene {
    /// All files that the scene was read from.
    pub files: Vec<PathBuf>,
    pub shapes: Vec<Shape>,
    owners: Owners,
    /// Instances of groups of further shapes.
    pub instances: Instances,
    pub materials: Vec<AnyMaterial>,
    pub emitters: Emitters,
    pub accel: Accel,
    pub sensor: Sensor,
    pub integrator: AnyIntegrator,
    /// The light paths that find caustics, if there are any.
    pub caustics: Option<Caustics>,
    /// The light paths that find sources for pixels that share, if there are any; see
    /// [`crate::render::plan::reuse`].
    pub light_sources: Option<LightSources>,
    /// The specular shapes by which emitters are sampled, if they are.
    pub links: Option<Links>,
    /// The directions by which emitter samples are guided instead, if light paths have left photons.
    pub guide: Option<Guide>,
    pub mode: ColorMode,
    /// What its shapes, materials and emitters use, and the channels of its image.
    features: Features,
    /// Whether some material for which emitters are sampled has several lobes.
    pub several_lobes: bool,
    /// How long pilots took to settle what the file leaves open; a part of the time for loading.
    pub planning: Duration,
    /// A hash of the scene file with all it refers to, as 32 hexadecimal digits.
    pub hash: String,
}

/// What a scene uses beyond what every scene does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features(pub u32);

impl Features {
    /// Texture coordinates: something varies over a surface.
    pub const TEXTURES: u32 = 1;
    /// A material with a preferred direction.
    pub const ANISOTROPY: u32 = 2;
    /// Refraction that separates wavelengths.
    pub const DISPERSION: u32 = 4;
    /// Light from outside the scene.
    pub const ENVIRONMENT: u32 = 8;
    /// Light paths look for caustics, or emitters are sampled by specular surfaces.
    pub const CAUSTICS: u32 = 16;
    /// Pixels share what their paths find.
    pub const REUSE: u32 = 32;
    /// Instances of groups of shapes.
    pub const INSTANCES: u32 = 64;
    pub const ALL: u32 = 127;
    /// The kernel for textured scenes: features that often come together, cheap if unused.
    pub const TEXTURED: u32 = Self::TEXTURES | Self::ANISOTROPY | Self::ENVIRONMENT | Self::INSTANCES;

    /// Whether all of the other's are among these.
    pub fn cover(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// These but for the other's.
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The names of the features, for people.
    pub fn names(self) -> Vec<&'static str> {
        let all = [
            (Self::TEXTURES, "textures"),
            (Self::ANISOTROPY, "anisotropy"),
            (Self::DISPERSION, "dispersion"),
            (Self::ENVIRONMENT, "environment"),
            (Self::CAUSTICS, "caustics"),
            (Self::REUSE, "path re-use"),
            (Self::INSTANCES, "instances"),
        ];
        all.into_iter().filter(|(bit, _)| self.0 & bit != 0).map(|(_, name)| name).collect()
    }
}

impl Scene {
    /// What the scene uses, and the techniques that it is to be rendered by; decides which kernel runs.
    pub fn features(&self) -> Features {
        let seeks_casters = self.caustics.is_some() || self.links.is_some() || self.guide.is_some();
        let caustics = if seeks_casters { Features::CAUSTICS } else { 0 };
        let reuse = if self.integrator.reuse() > 1 { Features::REUSE } else { 0 };
        Features(self.features.0 | caustics | reuse)
    }

    /// The shape that a primitive belongs to, and its number there.
    #[inline]
    pub fn shape_of(&self, primitive: u32) -> (&Shape, u32) {
        if self.instances.have(primitive) {
            return self.instances.shape_of(primitive);
        }
        self.own_shape_of(primitive)
    }

    /// The shape that a primitive belongs to, not one of an instance, and its number there.
    #[inline(always)]
    fn own_shape_of(&self, primitive: u32) -> (&Shape, u32) {
        let shape = &self.shapes[self.owners.of(primitive)];
        (shape, primitive - shape.first_primitive)
    }

    /// The surface at a hit, as far as a kernel with these features needs it.
    #[inline(always)]
    pub fn surface<const F: u32>(&self, ray: &Ray, hit: &Hit) -> (&Shape, SurfacePoint) {
        if F & Features::INSTANCES != 0 && self.instances.have(hit.primitive) {
            return self.instances.surface(ray, hit);
        }
        let (shape, local) = self.own_shape_of(hit.primitive);
        let point = if F & Features::TEXTURES != 0 {
            shape.geometry.point::<true>(ray, hit, local)
        } else {
            shape.geometry.point::<false>(ray, hit, local)
        };
        (shape, point)
    }

    /// Prefetches the surfaces at hits, where primitives lie scattered over memory: first the indices of
    /// corners, then the corners.
    pub fn prefetch_surfaces(&self, hits: &[Option<Hit>]) {
        if !self.accel.is_scattered() {
            return;
        }
        for fetch in [Mesh::prefetch_triangle, Mesh::prefetch_corners] {
            for hit in hits.iter().flatten().filter(|hit| !self.instances.have(hit.primitive)) {
                let (shape, local) = self.own_shape_of(hit.primitive);
                if let Geometry::Mesh(mesh) = &shape.geometry {
                    fetch(mesh, local);
                }
            }
        }
    }

    /// A bound of the rounding error of a point `p` of a primitive, which may be that of numbers far larger than
    /// `p`: a ball of earth is centred far below.
    pub fn point_error(&self, primitive: u32, p: DVec3) -> f64 {
        if self.instances.have(primitive) {
            return self.instances.point_error(primitive, p);
        }
        self.own_shape_of(primitive).0.geometry.point_error()
    }

    /// How many pixels (in px²) the film sees for each unit of area across a camera ray at its point `p`.
    pub fn pixels_per_area(&self, ray: &Ray, p: DVec3) -> f64 {
        let (width, height) = self.sensor.film.size;
        self.sensor.camera.seen_per_area(ray, p) * (f64::from(width) * f64::from(height))
    }

    /// Light paths that find caustics, for each sample number.
    pub fn light_paths(&self) -> u32 {
        self.caustics.as_ref().map_or(0, |caustics| caustics.paths)
    }

    /// The number of the shape that a primitive belongs to: those of groups come after the others.
    pub fn shape_index(&self, primitive: u32) -> usize {
        if self.instances.have(primitive) {
            return self.shapes.len() + self.instances.shape_index(primitive);
        }
        self.owners.of(primitive)
    }

    /// Bytes of the shapes and of their acceleration structures; materials and textures are not counted.
    pub fn geometry_bytes(&self) -> usize {
        let all = self.shapes.iter().chain(self.instances.shapes());
        let meshes = all.map(|s| match &s.geometry {
            Geometry::Mesh(mesh) => mesh.bytes(),
            _ => size_of::<Geometry>(),
        });
        meshes.sum::<usize>() + self.accel.bytes() + self.instances.search_bytes()
    }
}
