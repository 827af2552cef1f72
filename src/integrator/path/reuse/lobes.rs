//! Rough receivers and sources.

use super::contribution::Contribution;
use super::shared::{Lobes, Receiver, Shared, Source};
use crate::bsdf::{AnyBsdf, Bsdf};
use crate::math::frame::unit;
use crate::math::{DVec3, Frame, length};
use crate::scene::{Features, Scene};
use crate::spectrum::Wavelengths;

/// The rough receivers of a group.
pub struct Lobed<'a> {
    pub λ: &'a Wavelengths,
    /// One entry per path of the group; empty if all receivers are matte.
    of: Vec<Option<At<'a>>>,
}

/// The BSDF of a rough receiver or source.
pub struct At<'a> {
    lobes: &'a Lobes,
    frame: Frame,
    bsdf: AnyBsdf<'a>,
}

impl<'a> Lobed<'a> {
    /// The rough receivers of a group whose paths have these wavelengths.
    pub fn new(scene: &'a Scene, group: &'a [Shared], λ: &'a Wavelengths) -> Self {
        let lobes = |shared: &'a Shared| shared.receiver.as_ref()?.lobes.as_ref();
        let some = group.iter().any(|shared| lobes(shared).is_some());
        let at = |shared: &'a Shared| lobes(shared).map(|lobes| At::new(scene, lobes, λ));
        Self { λ, of: if some { group.iter().map(at).collect() } else { vec![] } }
    }

    /// Whether all are matte.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }

    pub fn at(&self, receiver: usize) -> Option<&At<'a>> {
        self.of.get(receiver)?.as_ref()
    }
}

impl<'a> At<'a> {
    pub fn new(scene: &'a Scene, lobes: &'a Lobes, λ: &'a Wavelengths) -> Self {
        Self {
            lobes,
            frame: lobes.side.frame::<{ Features::ALL }>(&lobes.point),
            bsdf: scene.materials[lobes.side.material as usize].at(&lobes.point, λ),
        }
    }

    fn to_local(&self, w: DVec3) -> DVec3 {
        self.frame.to_local(w)
    }

    /// This receiver's part of a source, as if that were matte.
    pub fn receives(&self, receiver: &Receiver, source: &Source) -> Contribution {
        let way = source.p - receiver.p;
        let distance = length(way);
        let w = way / distance;
        let scattered = self.bsdf.evaluate(self.lobes.fixed, self.to_local(w));
        let geometry = std::f64::consts::PI * source.ng.dot(w).abs() / (distance * distance);
        Contribution {
            weight: receiver.weight * scattered.value,
            geometry,
            density: scattered.pdf * geometry,
        }
    }

    /// Completes the contribution to a receiver with the scattering at this rough source.
    pub fn sends(&self, receiver: &Receiver, source: &Source, contribution: &mut Contribution) {
        let towards = self.to_local(unit(receiver.p - source.p));
        let scattered = self.bsdf.evaluate(towards, self.lobes.fixed);
        contribution.weight *= scattered.value;
        contribution.density *= scattered.pdf;
    }
}
