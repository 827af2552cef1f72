//! A point of a surface where a path is scattered.

use crate::bsdf::{Bsdf, Lobe};
use crate::emitter::Gathers;
use crate::math::{DVec3, Frame, Origin};
use crate::scene::{Scene, Side};
use crate::shape::SurfacePoint;

/// A surface point where light is gathered.
pub struct Vertex<'a, B> {
    pub point: &'a SurfacePoint,
    pub primitive: u32,
    /// That of the side; see [`Side::frame`].
    pub frame: &'a Frame,
    pub bsdf: &'a B,
    /// Direction to where the path came from, in the frame: on a light path that is the light's side, not the
    /// camera's.
    pub wo: DVec3,
    pub side: &'a Side,
}

impl<'a, B> Vertex<'a, B> {
    /// The origin of rays that leave it.
    #[inline]
    pub fn origin(&self) -> Origin {
        Origin { p: self.point.p, primitive: self.primitive }
    }

    /// A vertex with this frame; `wo` is in world space, and is taken into the frame.
    #[inline]
    pub fn new(
        point: &'a SurfacePoint,
        primitive: u32,
        frame: &'a Frame,
        bsdf: &'a B,
        side: &'a Side,
        wo: DVec3,
    ) -> Self {
        Self { point, primitive, frame, bsdf, wo: frame.to_local(wo), side }
    }

    /// A world direction in the frame's coordinates.
    #[inline]
    pub fn to_local(&self, w: DVec3) -> DVec3 {
        self.frame.to_local(w)
    }

    /// A direction of the frame's coordinates in world space.
    #[inline]
    pub fn to_world(&self, w: DVec3) -> DVec3 {
        self.frame.to_world(w)
    }

    /// The normal (world) of the hemisphere from which light can be scattered, by the cosine or nearly; zero
    /// if light from outside any one hemisphere can be. `to_camera` is the direction (local) it is scattered in.
    #[inline]
    fn gathers_about(&self, to_camera: DVec3) -> DVec3 {
        let traits = self.side.traits;
        let normal = if traits.transmits || traits.relief { DVec3::ZERO } else { self.frame.n };
        if to_camera.z < 0.0 { -normal } else { normal }
    }
}

impl<B: Bsdf> Vertex<'_, B> {
    /// What sampling emitters needs to know of it: its lobe, too, where one of several is chosen. `to_camera`
    /// is the direction (local) in which their light is scattered, whichever end the path came from.
    #[inline]
    pub fn gathers(&self, scene: &Scene, to_camera: DVec3) -> Gathers {
        if !scene.emitters.chosen_by_place() {
            return Gathers::about(self.gathers_about(to_camera));
        }
        let lobe = self.bsdf.lobe(to_camera);
        let lobe =
            if lobe.share > 0.0 { Lobe { axis: self.to_world(lobe.axis), ..lobe } } else { Lobe::NONE };
        Gathers { n: self.gathers_about(to_camera), lobe }
    }
}
