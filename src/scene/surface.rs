//! A surface of a scene, and what lies on its two sides.

use super::Features;
use crate::bsdf::Traits;
use crate::math::Frame;
use crate::medium::Medium;
use crate::shape::{Geometry, SurfacePoint};
use std::sync::Arc;

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

    /// Whether light paths are aimed at it: a side of it is of a caster.
    pub fn is_caster(&self) -> bool {
        self.sides.iter().any(|side| side.traits.is_caster())
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
    /// Index of the material; beyond all if there is none.
    pub material: u32,
    /// Whether the material is seen as if from its front: the local frame is turned around.
    pub turned: bool,
    pub traits: Traits,
}

impl Side {
    /// That of something that scatters so without being a material of the scene, as a medium does or what measures light.
    pub const fn without_material(traits: Traits) -> Self {
        Self { material: u32::MAX, turned: false, traits }
    }

    /// The frame of the material at a point: about the shading normal, and upside down on a turned side, where
    /// it is left-handed.
    #[inline(always)]
    pub fn frame<const F: u32>(&self, point: &SurfacePoint) -> Frame {
        let frame = point.frame(F & Features::ANISOTROPY != 0 && self.traits.anisotropic);
        Frame { n: if self.turned { -frame.n } else { frame.n }, ..frame }
    }
}
