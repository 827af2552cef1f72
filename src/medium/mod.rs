//! Participating media: what fills the space between surfaces, and absorbs and scatters light.
//!
//! *How to add one*: write `medium/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES` and `parse`; add its line to
//! [`MEDIA`] and a variant to [`AnyExtinction`].

mod flight;
mod heterogeneous;
mod homogeneous;
mod majorants;

#[cfg(test)]
mod contract;

use crate::math::Ray;
use crate::phase::{AnyPhase, Isotropic, PHASES};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::{Entry, construct};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::volume::AnyVolume;
pub use flight::{FlightNumbers, Shares};
pub use heterogeneous::Heterogeneous;
pub use homogeneous::Homogeneous;
use std::sync::Arc;

/// A medium as a scene file declares it.
#[derive(Debug)]
pub struct Medium {
    pub phase: AnyPhase,
    /// Whether emitters are sampled from within. Where nothing but glass leads out, all such samples are in
    /// vain.
    pub samples_emitters: bool,
    /// The share of the light that a collision scatters.
    albedo: AnyVolume,
    /// Whether any is.
    pub scatters: bool,
    extinction: AnyExtinction,
}

/// How dense a medium is: its extinction coefficient σₜ, per unit of length.
#[derive(Debug)]
pub enum AnyExtinction {
    Homogeneous(Homogeneous),
    Heterogeneous(Box<Heterogeneous>),
}

macro_rules! media {
    ($($module:ident),* $(,)?) => {
        /// Every medium.
        pub static MEDIA: &[Entry<Arc<Medium>>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: |params| parse(params, $module::parse),
        }),*];
    };
}
media!(homogeneous, heterogeneous);

/// Reads what every medium has, and its density by `extinction`.
fn parse(
    params: &mut Params,
    extinction: impl Fn(&mut Params) -> Result<AnyExtinction, SceneError>,
) -> Result<Arc<Medium>, SceneError> {
    let about = "share of the light that a collision scatters";
    let albedo = AnyVolume::parameter(params, "albedo", 0.75, Usage::Reflectance, about)?;
    let extinction = extinction(params)?;
    let phase = match params.object("phase", "how light is scattered; by default alike in all directions")? {
        None => AnyPhase::Isotropic(Isotropic),
        Some(element) => construct(PHASES, element, params.loader, Usage::Unbounded)?,
    };
    let about = "whether emitters are sampled from within; in vain where only glass leads out";
    let samples_emitters = params.boolean("sample_emitters", true, about)?;
    params.boolean("has_spectral_extinction", true, "Mitsuba's; ignored, for it is looked at")?;
    let scatters = albedo.constant().is_none_or(|albedo| albedo.bound() > 0.0);
    Ok(Arc::new(Medium { phase, samples_emitters, albedo, scatters, extinction }))
}

/// What becomes of a path within a medium.
#[derive(Clone, Copy, Debug)]
pub enum Flight {
    /// It comes through, and its throughput is multiplied by this.
    Through(Spectrum),
    /// It is scattered at this distance, and its throughput is multiplied by this.
    Scattered(f64, Spectrum),
}

impl Medium {
    /// Draws how far a path gets along a ray before it is scattered, if it is before the ray's end. `carried`
    /// is its throughput, in whose proportion lanes are looked at (see [`Shares`]).
    pub fn fly(&self, ray: &Ray, carried: Spectrum, λ: &Wavelengths, numbers: &mut FlightNumbers) -> Flight {
        // Where nothing is scattered, what comes through is known and nothing needs to be drawn.
        if !self.scatters {
            return Flight::Through(self.transmittance(ray, λ, numbers));
        }
        let shares = Shares::of(carried, λ);
        let (collision, weight) = match &self.extinction {
            AnyExtinction::Homogeneous(medium) => medium.fly(ray.end, shares, λ, numbers),
            AnyExtinction::Heterogeneous(medium) => medium.fly(ray, shares, λ, numbers),
        };
        match collision {
            None => Flight::Through(weight),
            Some(t) => Flight::Scattered(t, weight * self.albedo.eval(ray.at(t), λ)),
        }
    }

    /// An estimate of the share of light that comes straight through to a ray's end; exact where the medium is
    /// homogeneous.
    pub fn transmittance(&self, ray: &Ray, λ: &Wavelengths, numbers: &mut FlightNumbers) -> Spectrum {
        match &self.extinction {
            AnyExtinction::Homogeneous(medium) => medium.transmittance(ray.end, λ),
            AnyExtinction::Heterogeneous(medium) => medium.transmittance(ray, λ, numbers),
        }
    }
}
