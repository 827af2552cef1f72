//! A scene: plain arrays of everything that a ray can meet and of all emitters, read from Mitsuba 3 XML.
//!
//! Reading has three stages. [`xml`] makes a tree of elements whose every piece knows its place in the file;
//! the models read their own parameters from it through [`params`]; `build` puts what they made into arrays.
//! Then pilots choose among the techniques that the file leaves open; see [`crate::render::plan`].

mod build;
pub mod catalogue;
mod encoding;
pub mod error;
mod features;
mod hash;
pub mod instances;
mod lamps;
pub mod loader;
pub(crate) mod objects;
mod overrides;
mod owners;
pub mod params;
pub mod registry;
pub mod spectrum;
mod surface;
pub mod transform;
#[cfg(test)]
pub(crate) mod trial;
mod upgrade;
pub mod xml;

use crate::bsdf::AnyMaterial;
use crate::emitter::Emitters;
use crate::integrator::{AnyIntegrator, Techniques};
use crate::math::{DVec3, Ray};
use crate::sensor::{Optics, Sensor};
use crate::shape::accel::Accel;
use crate::shape::{Geometry, Hit, Mesh, SurfacePoint};
use crate::spectrum::ColorMode;
pub use build::{read, read_text};
pub use features::Features;
use instances::Instances;
pub use overrides::Overrides;
use owners::Owners;
use std::path::PathBuf;
use std::time::Duration;
pub use surface::{Interface, Shape, Side};

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
    pub techniques: Techniques,
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

impl Scene {
    /// What the scene uses, and the techniques that it is to be rendered by; decides which kernel runs.
    pub fn features(&self) -> Features {
        let caustics = if self.techniques.seek_casters() { Features::CAUSTICS } else { 0 };
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
