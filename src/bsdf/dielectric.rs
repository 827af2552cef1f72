//! A smooth interface between two transparent materials: a mirror direction and a refracted one.
//!
//! Where the index depends on wavelength the lanes stay together in reflection, each with its own Fresnel
//! factor, and separate in refraction: lane 0 continues alone and represents all.

use super::fresnel::{self, Refraction};
use super::ior::{self, Index};
use super::sides::relative_eta;
use super::tints::Tints;
use super::{Bsdf, Evaluation, Material, Sample, Traits, mirror};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::{ColorMode, LANES, Spectrum, Wavelengths};

/// Wavelength of the helium line at which indices of glasses are quoted; RGB mode takes it for all colours.
const HELIUM_D_NM: f32 = 587.56;

/// An interface such as that of glass and air.
pub struct Dielectric {
    index: Index,
    schlick: bool,
    tints: Tints,
}

/// An interface at a point.
pub struct DielectricBsdf {
    /// η inside / η outside of lane 0.
    eta: f64,
    /// The same of all lanes, where they differ and are alive.
    lanes: Option<[f64; LANES]>,
    schlick: bool,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

impl Material for Dielectric {
    const NAME: &'static str = "dielectric";
    const ABOUT: &'static str = "A polished surface of glass, water or diamond, which may disperse.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="dielectric"/>"#,
        r#"<bsdf type="dielectric"><string name="int_ior" value="water"/><float name="ext_ior" value="1.5"/></bsdf>"#,
        r#"<bsdf type="dielectric">
            <float name="int_ior" value="2.4"/>
            <rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/>
            <rgb name="specular_transmittance" value="0.7, 0.8, 0.9"/>
        </bsdf>"#,
        r#"<bsdf type="dielectric"><string name="fresnel" value="schlick"/></bsdf>"#,
        r#"<bsdf type="dielectric"><string name="dispersion" value="sf11"/></bsdf>"#,
        r#"<bsdf type="dielectric"><spectrum name="int_ior" value="360:1.7, 500:1.55, 830:1.5"/></bsdf>"#,
    ];
    const WHITE: &'static [&'static str] = &[
        r#"<bsdf type="dielectric"/>"#,
        r#"<bsdf type="dielectric"><string name="fresnel" value="schlick"/></bsdf>"#,
        r#"<bsdf type="dielectric"><string name="dispersion" value="sf11"/></bsdf>"#,
    ];
    type Bsdf<'a> = DielectricBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let index = match ior::dispersive(params, "bk7")? {
            Index::Dispersive(law, outside) if params.loader.mode == ColorMode::Rgb => {
                Index::Constant(law.eta(HELIUM_D_NM) / outside)
            }
            index => index,
        };
        let about = "Fresnel's equations or Schlick's approximation to them (Etalon's own)";
        Ok(Self {
            index,
            schlick: params.choice("fresnel", &["exact", "schlick"], about)? == "schlick",
            tints: Tints::parse(params)?,
        })
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> DielectricBsdf {
        let (eta, lanes) = match &self.index {
            Index::Constant(eta) => (*eta, None),
            Index::Dispersive(law, outside) if λ.is_collapsed() => (law.eta(λ.nm[0]) / outside, None),
            Index::Dispersive(law, outside) => {
                let lanes = λ.nm.map(|nm| law.eta(nm) / outside);
                (lanes[0], Some(lanes))
            }
        };
        let [reflectance, transmittance] = self.tints.at(point, λ);
        DielectricBsdf { eta, lanes, schlick: self.schlick, reflectance, transmittance }
    }

    fn traits(&self) -> Traits {
        let dispersive = matches!(self.index, Index::Dispersive(..));
        Traits {
            textured: self.tints.varies(),
            dispersive,
            refracts: !dispersive,
            // With dispersion, the probabilities of lobes depend on the end from which the path lost its
            // other wavelengths.
            mirrors: !dispersive,
            transmits: true,
            ..Traits::default()
        }
    }
}

impl DielectricBsdf {
    /// Reflection and transmission for light at `cos` on the near side, `eta` = η far / η near.
    #[inline]
    fn interface(&self, cos: f64, eta: f64) -> Refraction {
        if self.schlick { fresnel::schlick(cos, eta) } else { fresnel::dielectric(cos, eta) }
    }

    /// Refraction of the only or the first lane; `weight` is the factor that the choice of the lobe leaves.
    fn refracted(&self, wo: DVec3, eta: f64, weight: Spectrum, probability: f64) -> Option<Sample> {
        let normal = if wo.z > 0.0 { DVec3::Z } else { -DVec3::Z };
        let wi = fresnel::refract(wo, normal, wo.z.abs(), eta)?;
        // Radiance is flux per solid angle, which refraction compresses by 1/η².
        let weight = self.transmittance * weight * (1.0 / (eta * eta)) as f32;
        Some(Sample::delta(wi, weight, probability, eta))
    }

    /// All lanes have the same index, or only one lane is left.
    fn sample_together(&self, wo: DVec3, lobe: f64) -> Option<Sample> {
        let eta = relative_eta(self.eta, wo);
        let face = self.interface(wo.z.abs(), eta);
        if lobe < face.reflectance {
            return Some(Sample::delta(mirror(wo), self.reflectance, face.reflectance, 1.0));
        }
        self.refracted(wo, eta, Spectrum::ONE, face.transmittance)
    }

    /// Reflection with probability P = the mean of Rᵢ leaves Rᵢ/P in each lane. Refraction leaves 8·T₀/(1 −
    /// P) in lane 0, whose wavelength is distributed as all lanes together are: the mean over lanes stays
    /// unbiased.
    fn sample_apart(&self, wo: DVec3, lobe: f64, lanes: &[f64; LANES]) -> Option<Sample> {
        let faces = lanes.map(|eta| self.interface(wo.z.abs(), relative_eta(eta, wo)));
        let mean = |f: fn(&Refraction) -> f64| faces.iter().map(f).sum::<f64>() / LANES as f64;
        let reflected = mean(|face| face.reflectance);
        if lobe < reflected {
            let factor = Spectrum::from_fn(|i| (faces[i].reflectance / reflected) as f32);
            return Some(Sample::delta(mirror(wo), self.reflectance * factor, reflected, 1.0));
        }
        let transmitted = mean(|face| face.transmittance);
        let mut weight = Spectrum::ZERO;
        weight.0[0] = (LANES as f64 * faces[0].transmittance / transmitted) as f32;
        let sample = self.refracted(wo, relative_eta(lanes[0], wo), weight, transmitted)?;
        Some(Sample { dispersed: true, ..sample })
    }
}

impl Bsdf for DielectricBsdf {
    #[inline]
    fn evaluate(&self, _wo: DVec3, _wi: DVec3) -> Evaluation {
        Evaluation::ZERO
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, _u: DVec2) -> Option<Sample> {
        if wo.z == 0.0 {
            return None;
        }
        match &self.lanes {
            Some(lanes) => self.sample_apart(wo, lobe, lanes),
            None => self.sample_together(wo, lobe),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::params::Usage;
    use crate::spectrum::materials::Dispersion;
    use crate::texture::AnyTexture;

    fn pane(λ: &Wavelengths) -> DielectricBsdf {
        let index = Index::Dispersive(Dispersion::named("sf11").unwrap(), 1.0);
        let one = || AnyTexture::default_value(1.0, Usage::Reflectance, ColorMode::Spectral);
        let glass =
            Dielectric { index, schlick: false, tints: Tints { reflectance: one(), transmittance: one() } };
        glass.at(&SurfacePoint::flat(), λ)
    }

    fn samples(pane: &DielectricBsdf, wo: DVec3) -> Vec<Sample> {
        const N: usize = 20_000;
        (0..N).filter_map(|i| pane.sample(wo, (i as f64 + 0.5) / N as f64, DVec2::ZERO)).collect()
    }

    /// Rᵢ reflected in every lane, and in refraction η²·weight of lane 0 alone worth all eight lanes' Tᵢ,
    /// where lane 0 takes each of their wavelengths in turn.
    #[test]
    fn apart_lanes_are_unbiased_together() {
        for wo in [
            DVec3::new(0.6, 0.0, 0.8),
            DVec3::new(0.3, 0.2, -0.87f64.sqrt()),
            DVec3::new(0.55, 0.0, -0.6975f64.sqrt()),
        ] {
            let (mut refracted, mut transmitted) = (0.0, 0.0);
            for turn in 0..LANES {
                let λ = Wavelengths::sample_visible((turn as f64 + 0.4) / LANES as f64);
                let pane = pane(&λ);
                let drawn = samples(&pane, wo);
                let (mut reflected, mut crossed) = ([0.0; LANES], 0.0);
                for s in &drawn {
                    if s.dispersed {
                        crossed += s.weight.0[0] as f64 * s.eta * s.eta / 20_000.0;
                        assert!(s.weight.0[1..].iter().all(|w| *w == 0.0));
                        continue;
                    }
                    for (sum, weight) in reflected.iter_mut().zip(s.weight.0) {
                        *sum += weight as f64 / 20_000.0;
                    }
                }
                for (i, lane) in reflected.into_iter().enumerate() {
                    let eta = Dispersion::named("sf11").unwrap().eta(λ.nm[i]);
                    let face = fresnel::dielectric(wo.z.abs(), relative_eta(eta, wo));
                    assert!((lane - face.reflectance).abs() < 2e-4, "{wo} {i}");
                    transmitted += if i == 0 { face.transmittance } else { 0.0 };
                }
                refracted += crossed / LANES as f64;
            }
            assert!((refracted - transmitted).abs() < 2e-3, "{wo}: {refracted} {transmitted}");
        }
    }

    #[test]
    fn a_lane_alone_loses_nothing() {
        let mut λ = Wavelengths::sample_visible(0.2);
        λ.collapse();
        for s in samples(&pane(&λ), DVec3::new(0.6, 0.0, 0.8)) {
            assert!(!s.dispersed && (s.weight.0[0] as f64 * s.eta * s.eta - 1.0).abs() < 1e-6, "{s:?}");
        }
    }
}
