//! A smooth metal: the mirror direction, times Fresnel's reflectance at each wavelength.

use super::metal::{Metal, Reflector};
use super::{Bsdf, Evaluation, Material, Sample, Traits, mirror};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;

/// A one-sided mirror of metal.
pub struct Conductor {
    metal: Metal,
}

/// A mirror at a point.
pub struct ConductorBsdf {
    metal: Reflector,
}

impl Material for Conductor {
    const NAME: &'static str = "conductor";
    const ABOUT: &'static str = "A polished metal: a mirror with the colour of the metal.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="conductor"/>"#,
        r#"<bsdf type="conductor"><string name="material" value="Au"/></bsdf>"#,
        r#"<bsdf type="conductor"><float name="eta" value="0.2"/><float name="k" value="3.9"/></bsdf>"#,
        r#"<bsdf type="conductor">
            <spectrum name="eta" value="400:1.5, 700:0.2"/><spectrum name="k" value="400:2, 700:4"/>
            <rgb name="specular_reflectance" value="0.9, 0.7, 0.5"/>
        </bsdf>"#,
    ];
    const WHITE: &'static [&'static str] = &[
        r#"<bsdf type="twosided"><bsdf type="conductor"><string name="material" value="none"/></bsdf></bsdf>"#,
    ];
    type Bsdf<'a> = ConductorBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        Ok(Self { metal: Metal::parse(params)? })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> ConductorBsdf {
        ConductorBsdf { metal: self.metal.at(point, λ) }
    }

    fn traits(&self) -> Traits {
        Traits { one_lobe: true, textured: self.metal.varies(), mirrors: true, ..Traits::default() }
    }
}

impl Bsdf for ConductorBsdf {
    #[inline]
    fn evaluate(&self, _wo: DVec3, _wi: DVec3) -> Evaluation {
        Evaluation::ZERO
    }

    #[inline]
    fn sample(&self, wo: DVec3, _lobe: f64, _u: DVec2) -> Option<Sample> {
        (wo.z > 0.0).then(|| Sample::delta(mirror(wo), self.metal.reflectance(wo.z), 1.0, 1.0))
    }
}
