//! Energy over roughness, index and angle: every model that has these parameters, against quadrature, against
//! energy conservation, and against the known loss of single scattering.

use crate::direction::from;
use crate::materials::Subject;
use etalon::bsdf::fresnel;
use validation::checks::{Effort, find};
use validation::microfacet::{Rough, Slopes};
use validation::scatterer::{DVec3, Laws};
use validation::statistics::{Verdict, seed_for};
use validation::{Outcome, Sample, Scatterer};

/// Roughnesses of the grid.
pub const ALPHAS: [f64; 7] = [0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 1.0];
/// Relative indices of refraction of the grid.
pub const INDICES: [f64; 5] = [1.0 / 2.4, 1.0 / 1.5, 1.1, 1.5, 2.4];
/// Angles of the grid in degrees from the normal.
pub const ANGLES: [f64; 9] = [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0, 89.0];

/// Largest error of an albedo of a rough surface, against the albedo of single scattering.
const ROUGH: f64 = 1e-3;
/// Largest error of an albedo of a smooth surface, against 1.
const SMOOTH: f64 = 1e-6;
/// Largest error of an albedo of white plastic: that of `f32` and of quadrature.
const FITTED: f64 = 1e-5;

/// A model at a point of the grid.
#[derive(Clone, Debug)]
pub struct Cell {
    pub name: String,
    snippet: String,
    degrees: f64,
    leaves: Leaves,
}

/// The expected albedo of a surface.
#[derive(Clone, Copy, Debug)]
enum Leaves {
    /// A lossless rough surface: the albedo of single scattering.
    Rough(Rough),
    /// A lossless smooth surface: 1.
    All,
    /// White plastic with this η: the albedo that Mitsuba's fit gives, for η = 2.4 up to 2.3 % above 1.
    Fitted(f64),
    /// At most 1.
    AtMostAll,
}

/// The whole grid, or the models whose name contains `wanted`.
pub fn cells(wanted: Option<&str>) -> Vec<Cell> {
    let mut cells = vec![];
    let mut add = |name: String, snippet: String, leaves: Leaves| {
        for degrees in ANGLES {
            let name = format!("{name}::furnace::{degrees}");
            cells.push(Cell { name, snippet: snippet.clone(), degrees, leaves });
        }
    };
    let index =
        |eta: f64| format!("<float name=\"int_ior\" value=\"{eta}\"/><float name=\"ext_ior\" value=\"1\"/>");
    let laws = [("beckmann", Slopes::Beckmann), ("ggx", Slopes::Ggx)];
    for (law, slopes) in laws {
        for alpha in ALPHAS {
            let shape = format!(
                "<string name=\"distribution\" value=\"{law}\"/><float name=\"alpha\" value=\"{alpha}\"/>"
            );
            let mirror = format!("<bsdf type=\"roughconductor\">{shape}</bsdf>");
            let rough = |eta| Leaves::Rough(Rough { slopes, alpha, eta });
            add(format!("roughconductor-{law}[{alpha}]"), mirror, rough(None));
            for eta in INDICES {
                let inside = format!("{shape}{}", index(eta));
                let glass = format!("<bsdf type=\"roughdielectric\">{inside}</bsdf>");
                add(format!("roughdielectric-{law}[{alpha},{eta:.4}]"), glass, rough(Some(eta)));
                if eta > 1.0 {
                    let plastic = format!("<bsdf type=\"roughplastic\">{inside}{WHITE}</bsdf>");
                    add(format!("roughplastic-{law}[{alpha},{eta:.4}]"), plastic, Leaves::AtMostAll);
                }
            }
        }
    }
    for eta in INDICES {
        for fresnel in ["exact", "schlick"] {
            let snippet = format!(
                "<bsdf type=\"dielectric\">{}<string name=\"fresnel\" value=\"{fresnel}\"/></bsdf>",
                index(eta)
            );
            add(format!("dielectric-{fresnel}[{eta:.4}]"), snippet, Leaves::All);
        }
        add(
            format!("thindielectric[{eta:.4}]"),
            format!("<bsdf type=\"thindielectric\">{}</bsdf>", index(eta)),
            Leaves::All,
        );
        if eta > 1.0 {
            let plastic = format!("<bsdf type=\"plastic\">{}{WHITE}</bsdf>", index(eta));
            add(format!("plastic[{eta:.4}]"), plastic, Leaves::Fitted(eta));
        }
    }
    add("conductor".into(), "<bsdf type=\"conductor\"/>".into(), Leaves::All);
    cells.retain(|cell| wanted.is_none_or(|word| cell.name.contains(word)));
    cells
}

const WHITE: &str =
    r#"<boolean name="nonlinear" value="true"/><spectrum name="diffuse_reflectance" value="1"/>"#;

impl Cell {
    /// The expected albedo, where it is known.
    pub fn expected(&self) -> Option<f64> {
        let cosine = from(self.degrees).z;
        match self.leaves {
            Leaves::Rough(rough) => Some(rough.albedo(cosine, 1e-5).value),
            Leaves::All => Some(1.0),
            Leaves::Fitted(eta) => Some(fitted(cosine, eta)),
            Leaves::AtMostAll => None,
        }
    }

    /// Runs the check `furnace`, and compares the albedo with the expected one.
    pub fn run(&self, effort: &Effort, number: u64) -> Result<Outcome, String> {
        let subject = Subject::new(&self.snippet)?;
        let subject = subject.placed();
        let wo = from(self.degrees);
        let check = find("furnace").ok_or("there is no furnace")?;
        let seed = seed_for(&self.name, number);
        let Some(expected) = self.expected() else {
            return Ok(check.run(&subject, wo, seed, effort).of(&self.name));
        };
        // Light is measured in units of the known excess of a fit, so that it does not hide another one.
        let unit = expected.max(1.0);
        let mut outcome = check.run(&Measured { subject: &subject, unit }, wo, seed, effort).of(&self.name);
        let integrated = outcome.figures.get("integrated").copied().unwrap_or(f64::NAN) * unit;
        let (albedo, margin) = match self.leaves {
            Leaves::All => (delta_albedo(&subject, wo), SMOOTH),
            Leaves::Fitted(_) => (integrated + delta_albedo(&subject, wo), FITTED),
            _ => (integrated, ROUGH),
        };
        let apart = (albedo - expected).abs();
        if apart.is_nan() || apart > margin {
            outcome.verdict = Verdict::Different;
        }
        if expected > 1.0 {
            outcome.message += &format!("; in units of {expected:.6}, which Mitsuba's fit makes of 1");
        } else {
            let lost = 1.0 - expected;
            outcome.message += &format!("; {albedo:.7} where {expected:.7} is expected ({lost:.4} lost)");
        }
        Ok(outcome.figure("expected", expected).figure("apart", apart))
    }
}

/// The albedo of white plastic at a cosine. With its reflectance R, the light that enters, and the internal
/// reflectance F, it is R + (1 − R)(1 − F)/(1 − F′), where F′ is what Mitsuba's plastic uses for F in the sum
/// of all orders: the fit of Egan and Hilgeman (1973). With the exact F it is 1.
fn fitted(cosine: f64, eta: f64) -> f64 {
    let reflectance = fresnel::dielectric(cosine, eta).reflectance;
    let exact = fresnel::diffuse_reflectance(1.0 / eta);
    let fit = 0.6681 + 0.0636 * eta + (0.7099 - 1.4399 / eta) / eta;
    reflectance + (1.0 - reflectance) * (1.0 - exact) / (1.0 - fit)
}

/// A subject whose light is measured in multiples of `unit`.
struct Measured<'a> {
    subject: &'a dyn Scatterer,
    unit: f64,
}

impl Scatterer for Measured<'_> {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.subject.value(wo, wi) / self.unit
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.subject.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let sample = self.subject.sample(wo, u)?;
        Some(Sample { weight: sample.weight / self.unit, ..sample })
    }

    fn laws(&self) -> Laws {
        self.subject.laws()
    }
}

/// Σ probability × weight over the delta lobes, as flux; exact but for rounding.
fn delta_albedo(subject: &dyn Scatterer, wo: DVec3) -> f64 {
    const NUMBERS: usize = 4096;
    let mut lobes: Vec<Sample> = vec![];
    for i in 0..=NUMBERS {
        let number = (i as f64 / NUMBERS as f64).min(1.0 - f64::EPSILON / 2.0);
        if let Some(sample) = subject.sample(wo, [number, 0.5, 0.5]).filter(|sample| sample.delta)
            && lobes.iter().all(|lobe| (lobe.wi - sample.wi).length() > 1e-12)
        {
            lobes.push(sample);
        }
    }
    lobes.iter().map(|lobe| lobe.pdf * lobe.weight * subject.laws().flux_factor(wo, lobe.wi)).sum()
}

/// The loss of single scattering on the whole grid as CSV, with a line for each roughness, index and
/// distribution.
pub fn losses() -> String {
    let angles: Vec<String> = ANGLES.iter().map(|angle| format!("{angle}°")).collect();
    let mut table = format!("law,alpha,eta,{}\n", angles.join(","));
    for (law, slopes) in [("beckmann", Slopes::Beckmann), ("ggx", Slopes::Ggx)] {
        for alpha in ALPHAS {
            for eta in [None].into_iter().chain(INDICES.map(Some)) {
                let rough = Rough { slopes, alpha, eta };
                let lost = ANGLES.map(|angle| 1.0 - rough.albedo(from(angle).z, 1e-5).value);
                let lost: Vec<String> = lost.iter().map(|lost| format!("{:.4}", lost.max(0.0))).collect();
                let eta = eta.map_or("mirror".into(), |eta| format!("{eta:.4}"));
                table += &format!("{law},{alpha},{eta},{}\n", lost.join(","));
            }
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_plastic_is_as_bright_as_the_fit_makes_it() {
        let effort = Effort { albedo: 0.05, ..crate::trial::effort(1 << 12, 1000, false) };
        let cells: Vec<Cell> =
            cells(Some("plastic[")).into_iter().filter(|c| !c.name.contains("rough")).collect();
        assert_eq!(cells.len(), 3 * ANGLES.len());
        for cell in cells {
            let outcome = cell.run(&effort, 0).unwrap();
            assert_ne!(outcome.verdict, Verdict::Different, "{}: {}", outcome.subject, outcome.message);
        }
        assert!(fitted(1.0, 2.4) > 1.02 && fitted(1.0, 1.5) < 1.002);
    }
}
