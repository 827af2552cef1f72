//! A pane too thin to bend light: reflection at both of its faces, summed to all orders, and straight
//! transmission.

use super::tints::Tints;
use super::{Bsdf, Evaluation, Material, Sample, Traits, fresnel, ior, mirror};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// A window pane modelled as a single sheet.
pub struct ThinDielectric {
    /// η inside / η outside.
    eta: f64,
    tints: Tints,
}

/// A window pane at a point.
pub struct ThinDielectricBsdf {
    eta: f64,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

impl Material for ThinDielectric {
    const NAME: &'static str = "thindielectric";
    const ABOUT: &'static str = "A thin pane, such as a window or a soap film without colours.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="thindielectric"/>"#,
        r#"<bsdf type="thindielectric"><string name="int_ior" value="diamond"/><float name="ext_ior" value="1"/></bsdf>"#,
        r#"<bsdf type="thindielectric">
            <rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/>
            <rgb name="specular_transmittance" value="0.7, 0.8, 0.9"/>
        </bsdf>"#,
    ];
    const WHITE: &'static [&'static str] = &[r#"<bsdf type="thindielectric"/>"#];
    type Bsdf<'a> = ThinDielectricBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        Ok(Self { eta: ior::relative(params, "bk7")?, tints: Tints::parse(params)? })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> ThinDielectricBsdf {
        let [reflectance, transmittance] = self.tints.at(point, λ);
        ThinDielectricBsdf { eta: self.eta, reflectance, transmittance }
    }

    fn traits(&self) -> Traits {
        let textured = self.tints.varies();
        Traits {
            textured,
            transmits: true,
            has_null: true,
            refracts: true,
            mirrors: true,
            ..Traits::default()
        }
    }
}

impl Bsdf for ThinDielectricBsdf {
    #[inline]
    fn evaluate(&self, _wo: DVec3, _wi: DVec3) -> Evaluation {
        Evaluation::ZERO
    }

    #[inline]
    fn null_transmission(&self, wo: DVec3) -> Spectrum {
        let face = fresnel::dielectric(wo.z.abs(), self.eta);
        self.transmittance * (face.transmittance / (1.0 + face.reflectance)) as f32
    }

    /// R + TRT + TR³T + … = 2R/(1 + R), and the rest, T/(1 + R), goes through.
    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, _u: DVec2) -> Option<Sample> {
        let face = fresnel::dielectric(wo.z.abs(), self.eta);
        let reflected = 2.0 * face.reflectance / (1.0 + face.reflectance);
        if lobe < reflected {
            return Some(Sample::delta(mirror(wo), self.reflectance, reflected, 1.0));
        }
        let transmitted = face.transmittance / (1.0 + face.reflectance);
        (transmitted > 0.0).then(|| Sample::null(wo, self.transmittance, transmitted))
    }
}
