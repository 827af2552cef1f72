//! Energy over roughness, index and angle: every model that has them, against quadrature, against physics, and against what
//! single scattering is known to lose.

use crate::materials::Subject;
use crate::trial::from;
use validation::checks::{Effort, find};
use validation::microfacet::{Rough, Slopes};
use validation::statistics::{Verdict, seed_for};
use validation::{Outcome, Scatterer};

/// The grid of the furnace.
pub const ALPHAS: [f64; 7] = [0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 1.0];
pub const INDICES: [f64; 5] = [1.0 / 2.4, 1.0 / 1.5, 1.1, 1.5, 2.4];
/// Degrees from the normal.
pub const ANGLES: [f64; 9] = [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0, 89.0];

/// How far an albedo may be from what single scattering leaves, or from 1 for rough and for smooth surfaces.
const ROUGH: f64 = 1e-3;
const SMOOTH: f64 = 1e-6;

/// A model at a point of the grid.
#[derive(Clone, Debug)]
pub struct Cell {
    pub name: String,
    snippet: String,
    degrees: f64,
    /// What must leave: known for lossless rough surfaces, 1 for smooth ones.
    rough: Option<Rough>,
    smooth: bool,
}

/// The whole grid, or the models whose name contains a word.
pub fn cells(wanted: Option<&str>) -> Vec<Cell> {
    let mut cells = vec![];
    let mut add = |name: String, snippet: String, rough: Option<Rough>, smooth: bool| {
        for degrees in ANGLES {
            let name = format!("{name}::furnace::{degrees}");
            cells.push(Cell { name, snippet: snippet.clone(), degrees, rough, smooth });
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
            let rough = |eta| Some(Rough { slopes, alpha, eta });
            add(format!("roughconductor-{law}[{alpha}]"), mirror, rough(None), false);
            for eta in INDICES {
                let inside = format!("{shape}{}", index(eta));
                let glass = format!("<bsdf type=\"roughdielectric\">{inside}</bsdf>");
                add(format!("roughdielectric-{law}[{alpha},{eta:.4}]"), glass, rough(Some(eta)), false);
                if eta > 1.0 {
                    let plastic = format!("<bsdf type=\"roughplastic\">{inside}{WHITE}</bsdf>");
                    add(format!("roughplastic-{law}[{alpha},{eta:.4}]"), plastic, None, false);
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
            add(format!("dielectric-{fresnel}[{eta:.4}]"), snippet, None, true);
        }
        add(
            format!("thindielectric[{eta:.4}]"),
            format!("<bsdf type=\"thindielectric\">{}</bsdf>", index(eta)),
            None,
            true,
        );
        if eta > 1.0 {
            let plastic = format!("<bsdf type=\"plastic\">{}{WHITE}</bsdf>", index(eta));
            add(format!("plastic[{eta:.4}]"), plastic, None, false);
        }
    }
    add("conductor".into(), "<bsdf type=\"conductor\"/>".into(), None, true);
    cells.retain(|cell| wanted.is_none_or(|word| cell.name.contains(word)));
    cells
}

const WHITE: &str =
    r#"<boolean name="nonlinear" value="true"/><spectrum name="diffuse_reflectance" value="1"/>"#;

impl Cell {
    /// What a lossless surface keeps, by single scattering.
    pub fn expected(&self) -> Option<f64> {
        let cosine = from(self.degrees).z;
        self.rough.map(|rough| rough.albedo(cosine, 1e-5).value).or(self.smooth.then_some(1.0))
    }

    /// The check `furnace`, and the albedo against what is expected.
    pub fn run(&self, effort: &Effort, number: u64) -> Result<Outcome, String> {
        let subject = Subject::new(&self.snippet)?;
        let wo = from(self.degrees);
        let check = find("furnace").ok_or("there is no furnace")?;
        let seed = seed_for(&self.name, number);
        let mut outcome = check.run(&subject, wo, seed, effort).of(&self.name);
        let Some(expected) = self.expected() else { return Ok(outcome) };
        let (albedo, margin) = if self.smooth {
            (delta_albedo(&subject, wo), SMOOTH)
        } else {
            (outcome.figures.get("integrated").copied().unwrap_or(f64::NAN), ROUGH)
        };
        let apart = (albedo - expected).abs();
        if apart.is_nan() || apart > margin {
            outcome.verdict = Verdict::Different;
        }
        let lost = 1.0 - expected;
        outcome.message += &format!("; {albedo:.7} where {expected:.7} is expected ({lost:.4} lost)");
        Ok(outcome.figure("expected", expected).figure("apart", apart))
    }
}

/// Σ probability × weight over the delta lobes, as flux; exact but for rounding.
fn delta_albedo(subject: &Subject, wo: validation::scatterer::DVec3) -> f64 {
    const NUMBERS: usize = 4096;
    let mut lobes: Vec<validation::Sample> = vec![];
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

/// What single scattering loses on the whole grid, as a table: CSV with a line for each roughness, index and law.
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
