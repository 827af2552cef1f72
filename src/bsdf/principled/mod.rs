//! Disney's principled model: one material for most of what artists need, by parameters of which all but the
//! index are between 0 and 1.
//!
//! Burley 2012, "Physically Based Shading at Disney", and 2015, "Extending the Disney BRDF to a BSDF with
//! Integrated Subsurface Scattering", in the form that Mitsuba gives them. It is a sum of lobes made for
//! looks: a matte one that brightens towards grazing, sheen, a clear coat, and microfacets that reflect as
//! metal or glass does and let through what `spec_trans` says. Nothing holds their sum below 1: with much
//! sheen or coat on a white base it sends out more than it gets.

pub mod base;
mod gtr1;
mod layers;
pub mod matte;

use super::ior::nearly_equal;
use super::{Material, Traits};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::Wavelengths;
use crate::texture::AnyTexture;
use base::{Base, share_at};
use gtr1::Gtr1;
pub use layers::PrincipledBsdf;

/// The parameters of the model.
pub struct Principled {
    base: Base,
    metallic: AnyTexture,
    spec_trans: AnyTexture,
    spec_tint: AnyTexture,
    clearcoat: AnyTexture,
    clearcoat_gloss: AnyTexture,
    /// η inside / η outside.
    eta: f64,
    rates: Rates,
}

/// Factors of the probabilities of lobes, besides the lobes' weights.
struct Rates {
    diffuse: f64,
    specular: f64,
    coat: f64,
}

impl Material for Principled {
    const NAME: &'static str = "principled";
    const ABOUT: &'static str =
        "Disney's model: matte, metal, glass, sheen and a clear coat, blended by artists' parameters.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="principled"/>"#,
        r#"<bsdf type="principled">
            <rgb name="base_color" value="0.8, 0.4, 0.2"/><float name="metallic" value="0.7"/><float name="roughness" value="0.4"/>
            <float name="anisotropic" value="0.6"/><float name="specular" value="0.8"/>
        </bsdf>"#,
        r#"<bsdf type="principled">
            <rgb name="base_color" value="0.2, 0.3, 0.5"/><float name="roughness" value="0.6"/><float name="flatness" value="0.5"/>
            <float name="sheen" value="0.5"/><float name="clearcoat" value="1"/><float name="clearcoat_gloss" value="0.2"/>
        </bsdf>"#,
        r#"<bsdf type="principled">
            <rgb name="base_color" value="0.9, 0.8, 0.6"/><float name="spec_trans" value="0.8"/><float name="eta" value="1.5"/>
            <float name="roughness" value="0.5"/><float name="anisotropic" value="0.3"/>
        </bsdf>"#,
        r#"<bsdf type="principled">
            <rgb name="base_color" value="0.3, 0.15, 0.2"/><float name="spec_tint" value="0.7"/><float name="sheen" value="0.1"/>
            <float name="sheen_tint" value="0.5"/><float name="main_specular_sampling_rate" value="0.5"/>
            <float name="clearcoat" value="0.1"/><float name="clearcoat_sampling_rate" value="2"/>
            <float name="diffuse_reflectance_sampling_rate" value="1.5"/>
        </bsdf>"#,
    ];
    type Bsdf<'a> = PrincipledBsdf;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let base = Base::parse(params)?;
        let mut share = |name, about| base::share(params, name, 0.0, about);
        let metallic =
            share("metallic", "share of metal, which has no other lobes than microfacets and coat")?;
        let spec_trans = share("spec_trans", "share of glass in what is no metal; the rest is matte")?;
        let spec_tint = share("spec_tint", "how far reflection of what is no metal has the base's colour")?;
        let clearcoat = share("clearcoat", "brightness of a second, colourless reflection")?;
        let clearcoat_gloss = share("clearcoat_gloss", "α of the coat: 0.1 at 0, 0.001 at 1")?;
        let eta = index(params, spec_trans.constant() != Some(0.0))?;
        let mut rate = |name, about| base::rate(params, name, about);
        let rates = Rates {
            diffuse: rate(
                "diffuse_reflectance_sampling_rate",
                "how readily the matte lobe is sampled, within 0.01 and 100",
            )?,
            specular: rate(
                "main_specular_sampling_rate",
                "how readily microfacets are sampled, within 0.01 and 100",
            )?,
            coat: rate("clearcoat_sampling_rate", "how readily the coat is sampled, within 0.01 and 100")?,
        };
        Ok(Self { base, metallic, spec_trans, spec_tint, clearcoat, clearcoat_gloss, eta, rates })
    }

    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> PrincipledBsdf {
        let share = |texture: &AnyTexture| share_at(texture, point);
        let [metallic, spec_trans, spec_tint, clearcoat] =
            [&self.metallic, &self.spec_trans, &self.spec_tint, &self.clearcoat].map(share);
        let matte = (1.0 - metallic) * (1.0 - spec_trans);
        let (diffuse, coat) = (matte * self.rates.diffuse, 0.25 * clearcoat * self.rates.coat);
        let total = diffuse + coat + self.rates.specular;
        let (base, hue) = self.base.at(point, λ, [matte, 1.0 - metallic], spec_tint);
        PrincipledBsdf {
            facets: self.base.facets(point, base.roughness),
            matte: base,
            hue,
            eta: self.eta,
            metallic,
            spec_tint,
            clearcoat,
            coat: Gtr1::new(0.1 + (0.001 - 0.1) * share(&self.clearcoat_gloss)),
            clear: (1.0 - metallic) * spec_trans,
            chances: if total > 0.0 { [diffuse / total, coat / total] } else { [0.0; 2] },
            specular_chance: if total > 0.0 { self.rates.specular / total } else { 0.0 },
        }
    }

    fn traits(&self) -> Traits {
        let transmits = self.spec_trans.constant() != Some(0.0);
        let shares =
            [&self.metallic, &self.spec_trans, &self.spec_tint, &self.clearcoat, &self.clearcoat_gloss];
        // More than the gloss of something matte.
        let bright = transmits || self.metallic.mean() > 0.5;
        Traits {
            has_density: true,
            only_rough: !transmits,
            transmits,
            glossy: bright && self.base.narrow(),
            anisotropic: self.base.anisotropic(),
            textured: self.base.varies() || shares.iter().any(|texture| texture.varies()),
            ..Traits::default()
        }
    }
}

/// `eta`, or what `specular` means: reflectance 0.08 · `specular` at normal incidence. What lets light
/// through must not have the index of what is outside.
fn index(params: &mut Params, transmits: bool) -> Result<f64, SceneError> {
    if params.has("eta") && params.has("specular") {
        return Err(params.error("eta", "`eta` beside `specular`", "expected one of them"));
    }
    let about = "index of refraction inside over that outside, instead of `specular`";
    if params.has("eta") {
        params.float_where("specular", 0.5, SPECULAR, "", |_| true)?;
        let eta = params.float_where("eta", 1.5, about, "a number above 0, from 1e-9 to 1e9", |eta| {
            super::ior::RANGE.contains(&eta)
        })?;
        return Ok(if transmits && nearly_equal(eta) { 1.001 } else { eta });
    }
    params.optional_float("eta", about)?;
    let specular = params.float_where("specular", 0.5, SPECULAR, "0 to 12", |s| (0.0..=12.0).contains(&s))?;
    let of = |specular: f64| 2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0;
    Ok(if transmits && nearly_equal(of(specular)) { of(1e-3) } else { of(specular) })
}

const SPECULAR: &str = "reflectance at normal incidence, in units of 0.08, up to 0.96";

#[cfg(test)]
mod tests {
    use crate::image::Image;
    use crate::load_text;
    use crate::render::{Progress, Settings, render};
    use crate::spectrum::ColorMode;

    /// A sheet of this material in a sky: its image, and how many of its samples are no number.
    fn sheet(material: &str, samples: u64) -> (Image, u64) {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"/>
            <sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
                <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film></sensor>
            <emitter type="constant"/><shape type="rectangle"><transform name="to_world"><scale value="9"/></transform>
                {material}</shape></scene>"#
        );
        let scene = load_text("sheet.xml", &text, ColorMode::Rgb).unwrap();
        let (image, report) =
            render(&scene, &Settings::of(&scene, 0..samples), &Progress::default()).unwrap();
        (image, report.non_finite)
    }

    /// Rates say how lobes are sampled, not what they do.
    #[test]
    fn a_rate_of_zero_leaves_no_lobe_out() {
        let brightness = |rate: &str| {
            let material = format!(
                r#"<bsdf type="principled"><float name="spec_trans" value="1"/><float name="eta" value="1.5"/>
                <float name="roughness" value="0.6"/><float name="main_specular_sampling_rate" value="{rate}"/></bsdf>"#
            );
            let (image, _) = sheet(&material, 4096);
            image.channels.iter().map(|of| of.mean.iter().sum::<f32>()).sum::<f32>()
        };
        let (usual, seldom) = (brightness("1"), brightness("0"));
        assert!((seldom / usual - 1.0).abs() < 0.01, "{usual} {seldom}");
    }

    #[test]
    fn what_is_next_to_nothing_is_a_number() {
        let glass = r#"<float name="spec_trans" value="1"/><float name="roughness" value="0.5"/>"#;
        let dark = |rgb: &str| format!(r#"<rgb name="base_color" value="{rgb}"/>"#);
        let tint = r#"<float name="spec_tint" value="1"/>"#;
        let sheen = r#"<float name="sheen" value="1"/><float name="sheen_tint" value="1"/>"#;
        let values = |name: &str, value: &str| format!(r#"<float name="{name}" value="{value}"/>"#);
        for (kind, parameters) in [
            ("principled", values("specular", "1e-33") + glass),
            ("principled", values("specular", "0") + glass),
            ("principled", values("eta", "1") + glass),
            ("principled", values("eta", "1.0000000000000002") + glass),
            ("principled", dark("1e-38, 0, 0") + tint),
            ("principled", dark("0") + tint),
            ("principledthin", dark("1e-39, 0, 0") + sheen),
        ] {
            let material = format!(r#"<bsdf type="{kind}">{parameters}</bsdf>"#);
            let (image, non_finite) = sheet(&material, 64);
            assert_eq!(non_finite, 0, "{material}");
            assert!(
                image.channels.iter().flat_map(|of| &of.mean).all(|value| value.is_finite()),
                "{material}"
            );
        }
    }
}
