//! Every material × example × check × direction.

use etalon::bsdf::{AnyMaterial, Bsdf, MATERIALS};
use etalon::math::DVec2;
use etalon::scene::loader::Loader;
use etalon::scene::xml;
use etalon::shape::SurfacePoint;
use etalon::spectrum::{ColorMode, Wavelengths};
use validation::checks::{CHECKS, Check, Effort};
use validation::scatterer::{DVec3, direction};
use validation::statistics::seed_for;
use validation::{Laws, Outcome, Sample, Scatterer};

/// Angles of incidence in degrees; over 90 is from below.
pub const ANGLES: [f64; 5] = [0.0, 35.0, 75.0, 89.0, 150.0];

/// A material at a point, as the checks see it: its first wavelength.
pub struct Subject {
    laws: Laws,
    material: AnyMaterial,
    point: SurfacePoint,
    λ: Wavelengths,
}

impl Subject {
    /// Reads a scene-file snippet.
    pub fn new(snippet: &str) -> Result<Self, String> {
        let text = format!("<scene version=\"3.0.0\">{snippet}</scene>");
        let document = xml::read_text("example.xml", &text).map_err(|e| e.to_string())?;
        let loader = Loader::new(&document, ColorMode::Spectral).map_err(|e| e.to_string())?;
        let material = AnyMaterial::parse(&document.root.children[0], &loader).map_err(|e| e.to_string())?;
        // Alone in its path, so that dispersion does not make it stand for the lanes that go elsewhere.
        let mut λ = Wavelengths::sample_visible(0.4);
        λ.collapse();
        let mut subject = Self { laws: Laws::default(), material, point: SurfacePoint::flat(), λ };
        let reciprocal = subject.material.laws().reciprocal;
        subject.laws = Laws { reciprocal, eta: subject.index(), ..Laws::default() };
        Ok(subject)
    }

    /// The relative index of the far side, as a refracted sample from the front tells it.
    fn index(&self) -> Option<f64> {
        let bsdf = self.material.at(&self.point, &self.λ);
        let tries = (0..256).map(|i| (i as f64 + 0.5) / 256.0);
        let samples = tries.filter_map(|lobe| bsdf.sample(direction(0.9, 0.3), lobe, DVec2::new(0.4, 0.2)));
        samples.map(|sample| sample.eta).find(|eta| *eta != 1.0)
    }
}

impl Scatterer for Subject {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.material.at(&self.point, &self.λ).evaluate(wo, wi).value.0[0] as f64
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.material.at(&self.point, &self.λ).evaluate(wo, wi).pdf
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let sample = self.material.at(&self.point, &self.λ).sample(wo, u[0], DVec2::new(u[1], u[2]))?;
        Some(Sample {
            wi: sample.wi,
            weight: sample.weight.0[0] as f64,
            pdf: sample.pdf,
            delta: sample.delta,
        })
    }

    fn laws(&self) -> Laws {
        self.laws
    }
}

/// One thing to be checked.
#[derive(Clone)]
pub struct Trial {
    pub name: String,
    snippet: &'static str,
    check: &'static Check,
    wo: DVec3,
}

/// All trials, or those of one material.
pub fn trials(material: Option<&str>) -> Vec<Trial> {
    let mut trials = vec![];
    for entry in MATERIALS.iter().filter(|e| material.is_none_or(|m| m == e.name)) {
        for (i, snippet) in entry.examples.iter().enumerate() {
            for check in CHECKS {
                for angle in ANGLES {
                    let name = format!("{}[{i}]::{}::{angle}", entry.name, check.name);
                    trials.push(Trial { name, snippet, check, wo: direction(libm_cos(angle), 0.7) });
                }
            }
        }
    }
    trials
}

fn libm_cos(degrees: f64) -> f64 {
    etalon::math::function::cos(degrees.to_radians())
}

impl Trial {
    /// Runs the check; `None` if it does not apply to what the material claims. `number` draws another seed.
    pub fn run(&self, samples: usize, level: f64, number: u64) -> Result<Option<Outcome>, String> {
        let subject = Subject::new(self.snippet)?;
        if !(self.check.applies)(&subject.laws()) {
            return Ok(None);
        }
        // Values are f32: digits end at 1e-38, and cosines of grazing angles multiply.
        let effort = Effort { samples, level, smallest: 1e-30, ..Effort::default() };
        let seed = seed_for(&self.name, number);
        Ok(Some((self.check.run)(&subject, self.wo, seed, &effort).of(&self.name)))
    }
}
