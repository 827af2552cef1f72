//! Trials of every material × example × check × direction.

use crate::companions::{Companion, Company, companies};
use crate::direction::{Direction, directions};
use crate::trial::{Source, Trial, trials_of};
use etalon::bsdf::{AnyBsdf, AnyMaterial, Bsdf, MATERIALS, WHITE};
use etalon::math::DVec2;
use etalon::scene::loader::Loader;
use etalon::scene::xml;
use etalon::shape::SurfacePoint;
use etalon::spectrum::{ColorMode, Wavelengths};
use std::sync::Arc;
use validation::scatterer::{DVec3, Limit, direction};
use validation::{Laws, Sample, Scatterer};

/// The random number that determines the subject's wavelength.
pub const HERO: f64 = 0.4;

/// A material at a point, as the checks see it: at its first wavelength.
pub struct Subject {
    laws: Laws,
    material: AnyMaterial,
    point: SurfacePoint,
    λ: Wavelengths,
    companies: [Company; 2],
    limit: Option<(Box<Subject>, f64)>,
}

impl Subject {
    /// Reads a scene-file snippet.
    pub fn new(snippet: &str) -> Result<Self, String> {
        let text = format!("<scene version=\"3.0.0\">{snippet}</scene>");
        let document = xml::read_text("example.xml", &text).map_err(|e| e.to_string())?;
        let loader = Loader::new(&document, ColorMode::Spectral).map_err(|e| e.to_string())?;
        let material = AnyMaterial::parse(&document.root.children[0], &loader).map_err(|e| e.to_string())?;
        // A single wavelength, so that its weight does not include the lanes that dispersion ends.
        let mut λ = Wavelengths::sample_visible(HERO);
        λ.collapse();
        let laws = Laws { reciprocal: material.is_reciprocal(), ..Laws::default() };
        let point = SurfacePoint::flat();
        let subject = Self { laws, material, point, λ, companies: companies(), limit: None };
        let laws = Laws { eta: subject.index(), ..laws };
        Ok(Self { laws, ..subject })
    }

    /// The same subject, claiming that it absorbs nothing.
    pub fn white(self) -> Self {
        Self { laws: Laws { lossless: true, ..self.laws }, ..self }
    }

    /// The same subject, claiming that its flux moments differ from those of `limit` by at most `within`.
    pub fn near(self, limit: Subject, within: f64) -> Self {
        Self { limit: Some((Box::new(limit), within)), ..self }
    }

    /// The material where it is, at other wavelengths.
    pub(crate) fn at<'a>(&'a self, λ: &'a Wavelengths) -> AnyBsdf<'a> {
        self.material.at(&self.point, λ)
    }

    /// With its textures and spectra evaluated.
    pub(crate) fn placed(&self) -> Placed<'_> {
        Placed { subject: self, bsdf: self.at(&self.λ) }
    }

    /// The relative index of the far side, from a refracted sample of light from the front at so small an
    /// angle that it crosses whatever the index is.
    fn index(&self) -> Option<f64> {
        let bsdf = self.placed().bsdf;
        let tries = (0..4096).map(|i| [(i % 64) as f64 / 64.0, (i / 64) as f64 / 64.0]);
        let samples = tries
            .filter_map(|[lobe, u]| bsdf.sample(direction(0.9999, 0.3), lobe, DVec2::new(u, 0.2 + 0.5 * u)));
        samples.map(|sample| sample.eta).find(|eta| *eta != 1.0)
    }
}

/// A subject with its textures and spectra evaluated.
pub(crate) struct Placed<'a> {
    subject: &'a Subject,
    bsdf: AnyBsdf<'a>,
}

impl Scatterer for Placed<'_> {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.bsdf.evaluate(wo, wi).value.0[0] as f64
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.bsdf.evaluate(wo, wi).pdf
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let sample = self.bsdf.sample(wo, u[0], DVec2::new(u[1], u[2]))?;
        let weight = sample.weight.0[0] as f64;
        Some(Sample { wi: sample.wi, weight, pdf: sample.pdf, delta: sample.delta })
    }

    fn laws(&self) -> Laws {
        self.subject.laws
    }

    fn companions(&self) -> Vec<Box<dyn Scatterer + '_>> {
        self.subject.companions()
    }

    fn limit(&self) -> Option<Limit<'_>> {
        self.subject.limit()
    }
}

impl Scatterer for Subject {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.placed().value(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.placed().pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        self.placed().sample(wo, u)
    }

    fn prepared(&self) -> Option<Box<dyn Scatterer + '_>> {
        Some(Box::new(self.placed()))
    }

    fn laws(&self) -> Laws {
        self.laws
    }

    fn companions(&self) -> Vec<Box<dyn Scatterer + '_>> {
        let companions = self.companies.iter().map(|company| Companion::new(self, company));
        companions.map(|companion| Box::new(companion) as Box<dyn Scatterer>).collect()
    }

    fn limit(&self) -> Option<Limit<'_>> {
        self.limit.as_ref().map(|(limit, within)| Limit { scatterer: limit.as_ref(), within: *within })
    }
}

/// The source of subjects of a scene-file snippet.
pub fn source(snippet: impl Into<String>) -> Source {
    let snippet = snippet.into();
    Arc::new(move || Subject::new(&snippet).map(|subject| Box::new(subject) as Box<dyn Scatterer>))
}

/// The directions from which the material of a snippet is asked. One that cannot be read says so when it is.
fn directions_of(snippet: &str) -> Vec<Direction> {
    directions(&Subject::new(snippet).map_or(Laws::default(), |subject| subject.laws))
}

/// All trials of the registry's materials, or those of one material.
pub fn trials(material: Option<&str>) -> Vec<Trial> {
    let asked = |name: &str| material.is_none_or(|m| m == name);
    let mut trials = vec![];
    for entry in MATERIALS.iter().filter(|entry| asked(entry.name)) {
        for (i, snippet) in entry.examples.iter().enumerate() {
            let name = format!("{}[{i}]", entry.name);
            trials.extend(trials_of(&name, &source(*snippet), &directions_of(snippet), &["limits"]));
        }
    }
    for (name, snippets) in WHITE.iter().filter(|(name, _)| asked(name)) {
        for (i, snippet) in snippets.iter().enumerate() {
            let white: Source = Arc::new(|| Ok(Box::new(Subject::new(snippet)?.white())));
            trials.extend(trials_of(
                &format!("{name}[white {i}]"),
                &white,
                &directions_of(snippet),
                &["limits"],
            ));
        }
    }
    trials
}
