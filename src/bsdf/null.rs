//! No surface at all.

use super::{Bsdf, Evaluation, Material, Sample, Traits};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// Light goes straight on.
pub struct Null;

impl Material for Null {
    const NAME: &'static str = "null";
    const ABOUT: &'static str = "An invisible surface, for the boundary of a medium.";
    const EXAMPLES: &'static [&'static str] = &[r#"<bsdf type="null"/>"#];
    const WHITE: &'static [&'static str] = &[r#"<bsdf type="null"/>"#];
    type Bsdf<'a> = &'a Null;

    fn parse(_params: &mut Params) -> Result<Self, SceneError> {
        Ok(Self)
    }

    #[inline]
    fn at<'a>(&'a self, _point: &'a SurfacePoint, _λ: &'a Wavelengths) -> &'a Null {
        self
    }

    fn traits(&self) -> Traits {
        Traits { transmits: true, has_null: true, ..Traits::default() }
    }
}

impl Bsdf for &Null {
    #[inline]
    fn evaluate(&self, _wo: DVec3, _wi: DVec3) -> Evaluation {
        Evaluation::ZERO
    }

    #[inline]
    fn null_transmission(&self, _wo: DVec3) -> Spectrum {
        Spectrum::ONE
    }

    #[inline]
    fn sample(&self, wo: DVec3, _lobe: f64, _u: DVec2) -> Option<Sample> {
        Some(Sample::null(wo, Spectrum::ONE, 1.0))
    }
}
