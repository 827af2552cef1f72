//! Relations between renders that hold whatever the true image is.
//!
//! A relation is data: two sides, each a sum of renders, and how they must agree. Renders that can be
//! bit-identical must be; all others must be *equivalent*, by the harness's own comparison of images: the 99
//! % interval of the ratio of the means lies within the margin, and no tile differs significantly.
//!
//! *How to add one*: an entry in the `relations` of the file it belongs to; for a new family, a file and its
//! line in [`FAMILIES`].

mod by_mirrors;
mod caustics;
mod exact;
mod flat_caustic;
mod guided;
mod invisible;
mod lights;
mod many_lamps;
mod methods;
mod motion;
mod neighbours;
mod reuse;
pub(crate) mod still_life;
mod tessellation;
mod through_glass;
mod transport;
mod wavelengths;

pub use reuse::one_of;

use crate::stage::{Family, TWICE, confirmed, expose, fault, gather, load, measured};
use etalon::film::BLOCK;
use etalon::film::Window;
use etalon::image::merge;
use etalon::render::Settings;
use etalon::spectrum::ColorMode;
use std::path::PathBuf;
use validation::image::{self, Image};
use validation::statistics::seed_for;
use validation::{Outcome, Verdict};

/// A render, as one term of a sum.
#[derive(Clone, Debug)]
pub struct Term {
    pub scene: String,
    pub mode: ColorMode,
    /// Factor on the image.
    pub factor: f64,
    /// Whether the image is mirrored: its columns are reversed.
    pub mirrored: bool,
    /// Window of the film to render; all if absent.
    pub window: Option<Window>,
    /// Window to cut from the whole image; all if absent.
    pub cut: Option<Window>,
    /// Shares of the samples at which shards end; the shards are rendered separately and merged. Empty for a
    /// single render.
    pub shards: &'static [f64],
    /// The part or function of the image to compare; the whole image if absent.
    pub view: Option<fn(&Image) -> Image>,
}

impl Term {
    pub fn new(scene: String) -> Self {
        let (window, cut, view) = (None, None, None);
        Self { scene, mode: ColorMode::Rgb, factor: 1.0, mirrored: false, window, cut, shards: &[], view }
    }

    pub fn times(self, factor: f64) -> Self {
        Self { factor, ..self }
    }

    pub(crate) fn image(&self, samples: u64, seed: u32) -> Result<Image, String> {
        let scene = load(&self.scene, self.mode)?;
        let window = self.window.unwrap_or(scene.sensor.film.crop);
        let settings = |samples, shard| Settings { seed, window, shard, ..Settings::of(&scene, samples) };
        let rendered = if self.shards.is_empty() {
            expose(&scene, &settings(0..samples, false))?
        } else {
            // Shards begin at whole blocks of samples.
            let ends = self.shards.iter().map(|share| (share * samples as f64) as u64 / BLOCK * BLOCK);
            let mut parts = vec![];
            let mut start = 0;
            for end in ends.chain([samples]) {
                parts.push((PathBuf::from("shard"), expose(&scene, &settings(start..end, true))?));
                start = end;
            }
            parts.reverse();
            merge(parts).map_err(|e| e.to_string())?
        };
        let mut image = measured(&rendered);
        if let Some(view) = self.view {
            image = view(&image);
        }
        if let Some(cut) = self.cut {
            image = part(&image, cut);
        }
        for channel in &mut image.channels {
            channel.mean.iter_mut().for_each(|v| *v *= self.factor);
            channel.variance.iter_mut().flatten().for_each(|v| *v *= self.factor * self.factor);
            if self.mirrored {
                channel.mean.chunks_mut(image.width).for_each(<[f64]>::reverse);
                channel
                    .variance
                    .iter_mut()
                    .flat_map(|v| v.chunks_mut(image.width))
                    .for_each(<[f64]>::reverse);
            }
        }
        Ok(image)
    }
}

fn part(image: &Image, window: Window) -> Image {
    let [x, y, width, height] = [window.x, window.y, window.width, window.height].map(|v| v as usize);
    let inside =
        |column: usize, row: usize| (x..x + width).contains(&column) && (y..y + height).contains(&row);
    chosen(image, (width, height), inside)
}

/// The pixels (column, row) that `wanted` accepts, in row-major order, as an image of this width and height.
fn chosen(image: &Image, (width, height): (usize, usize), wanted: impl Fn(usize, usize) -> bool) -> Image {
    let pick = |values: &[f64]| {
        let pixels = values.iter().enumerate();
        let wanted = pixels.filter(|(i, _)| wanted(i % image.width, i / image.width));
        wanted.map(|(_, value)| *value).collect::<Vec<f64>>()
    };
    let mut channels = image.channels.clone();
    for channel in &mut channels {
        channel.mean = pick(&channel.mean);
        channel.variance = channel.variance.as_deref().map(pick);
    }
    Image { width, height, channels }
}

/// How both sides must agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alike {
    /// Bit for bit, means and variances; both sides have the same seed.
    Bits,
    /// In expectation, within this relative margin; every term has a seed of its own.
    Expectation(f64),
    /// The same of the mean alone: of pictures that show different things.
    Mean(f64),
}

impl Alike {
    /// The largest relative difference that counts as equivalent.
    pub fn margin(self) -> f64 {
        match self {
            Self::Bits => 0.0,
            Self::Expectation(margin) | Self::Mean(margin) => margin,
        }
    }
}

/// Two sums of renders that must agree.
#[derive(Clone, Debug)]
pub struct Relation {
    pub name: String,
    pub left: Vec<Term>,
    pub right: Vec<Term>,
    pub alike: Alike,
    /// Samples per pixel of each render.
    pub samples: u64,
    /// Whether the relation takes long and similar ones exist: `cargo test` skips it unless told to run
    /// ignored tests, `validate scenes` does not.
    pub at_length: bool,
}

/// All families, by name.
pub const FAMILIES: &[Family<Relation>] = &[
    ("exact", exact::relations),
    ("by_mirrors", by_mirrors::relations),
    ("caustics", caustics::relations),
    ("flat_caustic", flat_caustic::relations),
    ("guided", guided::relations),
    ("lights", lights::relations),
    ("many_lamps", many_lamps::relations),
    ("motion", motion::relations),
    ("invisible", invisible::relations),
    ("methods", methods::relations),
    ("neighbours", neighbours::relations),
    ("reuse", reuse::relations),
    ("tessellation", tessellation::relations),
    ("through_glass", through_glass::relations),
    ("transport", transport::relations),
    ("wavelengths", wavelengths::relations),
];

/// All relations, named `family::relation`.
pub fn relations() -> Vec<Relation> {
    gather(FAMILIES, |relation| &mut relation.name)
}

impl Relation {
    /// A relation of bit-identical renders.
    pub fn bits(name: impl Into<String>, left: Term, right: Term) -> Self {
        Self {
            name: name.into(),
            left: vec![left],
            right: vec![right],
            alike: Alike::Bits,
            samples: 32,
            at_length: false,
        }
    }

    /// A relation of renders equal in expectation, within 1 %.
    pub fn expectation(name: impl Into<String>, left: Vec<Term>, right: Vec<Term>) -> Self {
        Self {
            name: name.into(),
            left,
            right,
            alike: Alike::Expectation(0.01),
            samples: 1024,
            at_length: false,
        }
    }

    /// The same relation of spectral renders.
    pub fn in_spectra(self) -> Self {
        let spectral = |terms: Vec<Term>| {
            terms.into_iter().map(|term| Term { mode: ColorMode::Spectral, ..term }).collect()
        };
        Self { left: spectral(self.left), right: spectral(self.right), ..self }
    }

    pub fn samples(self, samples: u64) -> Self {
        Self { samples, ..self }
    }

    /// The same relation with `times` as many samples: where fewer leave the first run inconclusive, the
    /// second run costs more than that.
    pub fn longer(self, times: u64) -> Self {
        Self { samples: self.samples * times, ..self }
    }

    /// The same relation of the means of pictures alone, which show different things.
    pub fn of_means(self) -> Self {
        Self { alike: Alike::Mean(self.alike.margin()), ..self }
    }

    /// The same relation within this relative margin.
    pub fn within(self, margin: f64) -> Self {
        Self { alike: Alike::Expectation(margin), ..self }
    }

    pub fn at_length(self) -> Self {
        Self { at_length: true, ..self }
    }

    /// The same relation with a quarter of the margin and 16 times the samples.
    pub fn thorough(self) -> Self {
        let alike = match self.alike {
            Alike::Bits => Alike::Bits,
            Alike::Expectation(margin) => Alike::Expectation(0.25 * margin),
            Alike::Mean(margin) => Alike::Mean(0.25 * margin),
        };
        Self { alike, samples: 16 * self.samples, ..self }
    }

    /// Renders with `effort` times the samples and compares; `number` determines the seeds.
    pub fn check(&self, effort: u64, number: u64) -> Result<Outcome, String> {
        let terms = self.left.len() as u64;
        let seed = |term: u64| match self.alike {
            Alike::Bits => seed_for(&self.name, number) as u32,
            Alike::Expectation(_) | Alike::Mean(_) => {
                seed_for(&format!("{} {term}", self.name), number) as u32
            }
        };
        let side = |sum: &[Term], first: u64| {
            let images = sum.iter().zip(first..);
            let images: Result<Vec<Image>, String> =
                images.map(|(term, i)| term.image(self.samples * effort, seed(i))).collect();
            images.map(add)
        };
        let [left, right] = [side(&self.left, 0)?, side(&self.right, terms)?];
        if left.channels.iter().any(|c| c.mean.iter().all(|v| *v == 0.0)) {
            let message = "a black channel shows nothing".to_owned();
            return Ok(Outcome::new("relation", Verdict::Inconclusive, message).of(&self.name));
        }
        let settings = |margin| image::Settings {
            tile_size: 8,
            ..image::Settings::with_margin(margin).with_tiles_within_noise()
        };
        let settings = match self.alike {
            Alike::Bits => return Ok(identical(&left, &right).of(&self.name)),
            Alike::Expectation(margin) => settings(margin),
            Alike::Mean(margin) => image::Settings { tile_margin: f64::INFINITY, ..settings(margin) },
        };
        let comparison = image::compare(&left, &right, &settings).map_err(|e| e.to_string())?;
        Ok(comparison.outcome().of(&self.name))
    }

    /// The relation as a test: it fails if four times the samples with other seeds confirm an inconclusive or
    /// different verdict.
    pub fn test(&self) -> Result<(), String> {
        // Different bits do not depend on the number of samples.
        let tries = if self.alike == Alike::Bits { &TWICE[..1] } else { &TWICE };
        confirmed(tries, |effort, number| Ok(fault(&self.check(effort, number)?)))
    }
}

/// Sum of independent renders, in mean and variance.
fn add(images: Vec<Image>) -> Image {
    let mut images = images.into_iter();
    let mut sum = images.next().unwrap_or(Image { width: 0, height: 0, channels: vec![] });
    let add = |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    for image in images {
        for (to, from) in sum.channels.iter_mut().zip(&image.channels) {
            add(&mut to.mean, &from.mean);
            match (&mut to.variance, &from.variance) {
                (Some(to), Some(from)) => add(to, from),
                (to, _) => *to = None,
            }
        }
    }
    sum
}

/// The outcome of a comparison of every mean and variance. f64 represents the f32 of the file, and its
/// products with powers of two, exactly.
fn identical(left: &Image, right: &Image) -> Outcome {
    let values = |image: &Image| {
        let all = image.channels.iter().flat_map(|c| c.mean.iter().chain(c.variance.iter().flatten()));
        all.map(|v| v.to_bits()).collect::<Vec<u64>>()
    };
    let (a, b) = (values(left), values(right));
    let differing = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    let verdict = if differing == 0 && a.len() == b.len() { Verdict::Equivalent } else { Verdict::Different };
    let message = match verdict {
        Verdict::Equivalent => format!("{} values identical bit for bit", a.len()),
        _ => format!("{differing} of {} values differ", a.len().max(b.len())),
    };
    Outcome::new("relation", verdict, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        let mut names: Vec<String> = relations().into_iter().map(|r| r.name).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert!(names.len() == count && count >= 20, "{count}");
    }

    /// A text that was to be replaced, and has become another, would leave a scene to be compared with itself.
    #[test]
    fn sides_differ() {
        let told = |terms: &[Term]| terms.iter().map(|term| format!("{term:?}")).collect::<Vec<_>>();
        for Relation { name, left, right, .. } in relations() {
            assert_ne!(told(&left), told(&right), "{name}");
        }
    }

    #[test]
    fn a_brighter_light_is_noticed() {
        let [scene, brighter] =
            [1.0, 1.02].map(|factor| still_life::with_light(&still_life::lamp(8.0 * factor)));
        let terms = [scene, brighter].map(|scene| vec![Term::new(scene)]);
        let [left, right] = terms;
        let outcome = Relation::expectation("brighter", left.clone(), right.clone()).check(1, 0).unwrap();
        assert_eq!(outcome.verdict, Verdict::Different, "{}", outcome.message);
        let bits = Relation {
            left,
            right,
            ..Relation::bits("x", Term::new(String::new()), Term::new(String::new()))
        };
        assert_eq!(bits.check(1, 0).unwrap().verdict, Verdict::Different);
    }
}
