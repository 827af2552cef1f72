//! Comparison of values and densities with Mitsuba's, from `validation/references/golden/bsdf.json` (made by
//! `validation/peers/golden_bsdf.py`).
//!
//! Mitsuba computes in f32. The effect of a rounding depends on the directions, so the tolerance is measured:
//! the largest change that one ulp of any coordinate of ωo or ωi makes here, times `ROUNDINGS`, and at least
//! as many ulps of the number itself.

use etalon::bsdf::{AnyMaterial, Bsdf};
use etalon::math::{DVec2, DVec3};
use etalon::scene::loader::Loader;
use etalon::scene::xml;
use etalon::shape::SurfacePoint;
use etalon::spectrum::{ColorMode, Wavelengths};
use serde::Deserialize;
use validation::statistics::worst_of;

/// Number of consecutive operations in an evaluation whose roundings add up.
const ROUNDINGS: f64 = 32.0;

/// Threshold below which numbers are not compared. Mitsuba sets a microfacet density to zero where density
/// times cosine is below 10⁻²⁰, to avoid an overflow elsewhere (`microfacet.h`). Divided by the cosines of
/// the steepest directions of the grid that is 10⁻¹⁸.
const SMALLEST: f64 = 1e-18;

/// The committed golden file.
#[derive(Deserialize)]
pub struct Golden {
    pub mitsuba: String,
    wavelengths: [f32; 4],
    wo: Vec<[f64; 3]>,
    wi: Vec<[f64; 3]>,
    pub examples: Vec<Example>,
}

/// Mitsuba's results for one example of the registry.
#[derive(Clone, Deserialize)]
pub struct Example {
    pub name: String,
    pub snippet: String,
    /// The reason why Mitsuba has no equivalent.
    pub missing: Option<String>,
    #[serde(default)]
    value: Vec<[f64; 4]>,
    #[serde(default)]
    pdf: Vec<f64>,
}

/// Differences that rounding does not explain.
pub struct Differences {
    /// The largest relative difference of values and that of densities; 0 if there is none.
    pub worst: [f64; 2],
    /// The place of the first difference, and the number of differences.
    pub message: Option<String>,
}

impl Golden {
    /// Reads the committed file.
    pub fn load() -> Result<Self, String> {
        crate::files::json(&crate::references::folder().join("golden/bsdf.json"))
    }

    /// Compares one example. Errors: the example or the golden file cannot be read.
    pub fn check(&self, example: &Example) -> Result<Differences, String> {
        let model = Model::new(&example.snippet, &self.wavelengths)?;
        if example.value.len() != self.wo.len() || example.pdf.len() != self.wo.len() {
            return Err("the golden file lacks numbers; make it anew".into());
        }
        let (mut wrong, mut worst) = (vec![], [0.0f64; 2]);
        for (i, (wo, wi)) in self.wo.iter().zip(&self.wi).enumerate() {
            let [a, b, c, d] = example.value[i];
            let theirs = [a, b, c, d, example.pdf[i]];
            let ours = model.evaluate(*wo, *wi);
            // Where all values are zero, a density of directions that are never drawn is irrelevant:
            // Mitsuba's `principled` has one behind opaque surfaces.
            if example.name.starts_with("principled") && ours == [0.0; 5] && theirs[..4] == [0.0; 4] {
                continue;
            }
            let allowed = model.allowed(*wo, *wi, &ours);
            for (k, what) in ["value 0", "value 1", "value 2", "value 3", "pdf"].iter().enumerate() {
                let difference = (ours[k] - theirs[k]).abs();
                // Not `>`: a NaN must count as wrong.
                if !(difference <= allowed[k] || worst_of(ours[k], theirs[k]) < SMALLEST) {
                    let (ours, theirs, allowed) = (ours[k], theirs[k], allowed[k]);
                    let relative = (ours - theirs).abs() / ours.abs().max(theirs.abs());
                    let kind = k / 4;
                    worst[kind] =
                        if relative > worst[kind] || relative.is_nan() { relative } else { worst[kind] };
                    wrong.push(format!(
                        "{what} of wo = {wo:?}, wi = {wi:?} is {ours:.7e}, Mitsuba's {theirs:.7e} (± {allowed:.1e})"
                    ));
                }
            }
        }
        let message = wrong.first().map(|first| {
            let (count, total) = (wrong.len(), 5 * self.wo.len());
            format!(
                "{count} of {total} numbers differ, values by up to {:.1e}, densities {:.1e}; {first}",
                worst[0], worst[1]
            )
        });
        Ok(Differences { worst, message })
    }
}

struct Model {
    material: AnyMaterial,
    point: SurfacePoint,
    λ: Wavelengths,
}

impl Model {
    fn new(snippet: &str, wavelengths: &[f32; 4]) -> Result<Self, String> {
        let text = format!("<scene version=\"3.0.0\">{snippet}</scene>");
        let document = xml::read_text("example.xml", &text).map_err(|e| e.to_string())?;
        let loader = Loader::new(&document, ColorMode::Spectral).map_err(|e| e.to_string())?;
        let material = AnyMaterial::parse(&document.root.children[0], &loader).map_err(|e| e.to_string())?;
        let mut λ = Wavelengths::sample_visible(0.5);
        // Eight lanes carry the four wavelengths twice, so that means over lanes are means over the four.
        λ.nm = std::array::from_fn(|lane| wavelengths[lane % 4]);
        let point = SurfacePoint { uv: DVec2::new(0.25, 0.25), ..SurfacePoint::flat() };
        Ok(Self { material, point, λ })
    }

    /// The four values and the density.
    fn evaluate(&self, wo: [f64; 3], wi: [f64; 3]) -> [f64; 5] {
        let found =
            self.material.at(&self.point, &self.λ).evaluate(DVec3::from_array(wo), DVec3::from_array(wi));
        let [a, b, c, d, ..] = found.value.0.map(f64::from);
        [a, b, c, d, found.pdf]
    }

    fn allowed(&self, wo: [f64; 3], wi: [f64; 3], here: &[f64; 5]) -> [f64; 5] {
        let ulp = f64::from(f32::EPSILON);
        let mut allowed = here.map(|v| ulp * v.abs());
        for axis in 0..6 {
            for sign in [-1.0, 1.0] {
                let mut moved = [wo, wi];
                moved[axis / 3][axis % 3] *= 1.0 + sign * ulp;
                let there = self.evaluate(moved[0], moved[1]);
                (0..5).for_each(|k| allowed[k] = worst_of(allowed[k], there[k] - here[k]));
            }
        }
        allowed.map(|a| ROUNDINGS * a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_a_per_cent_is_found() {
        let mut golden = Golden::load().unwrap();
        let mut example = golden.examples.iter().find(|e| e.name == "roughconductor[1]").unwrap().clone();
        assert_eq!(golden.check(&example).unwrap().message, None);
        example.pdf.iter_mut().for_each(|p| *p *= 1.001);
        let worst = golden.check(&example).unwrap().worst;
        assert!(worst[0] == 0.0 && (worst[1] - 0.001).abs() < 1e-4, "{worst:?}");
        golden.wo.pop();
        assert!(golden.check(&example).is_err_and(|e| e.contains("make it anew")));
    }
}
