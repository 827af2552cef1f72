//! The results of one renderer, from its pictures.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use validation::converge::{Curve, Errors, Measured, Ratio, Rung, curve, mean, page, ratio, ratio_of_means};
use validation::html::escape;
use validation::statistics::seed_for;

use super::bench::Bench;
use super::{Run, Settings};
use crate::renderers::mean_of;

/// The results of a renderer.
#[derive(Serialize)]
pub struct Line {
    pub renderer: String,
    /// Samples per pixel of each rung.
    pub samples: Vec<u32>,
    /// Number of seeds with all rungs.
    pub seeds: usize,
    /// The renderer whose converged mean is the reference.
    pub mean_of: String,
    /// The mean of its longest pictures over that of the reference.
    pub brightness: Option<Measured>,
    /// The reference's brightness over that of the first renderer's reference, where they are different
    /// pictures: far from 1 if the two do not render the same scene.
    pub mean_over_first: Option<Measured>,
    /// Mean start-up time in seconds.
    pub startup: f64,
    pub trimmed: Option<Curve>,
    pub whole: Option<Curve>,
    pub median: Option<Curve>,
    /// The first renderer's efficiency over this one's, by trimmed error.
    pub ratio_trimmed: Option<Ratio>,
    /// The first renderer's efficiency over this one's, by untrimmed error.
    pub ratio_whole: Option<Ratio>,
}

/// A selection of one of the errors.
type Measure = fn(&Errors) -> f64;

/// The seeds for which a renderer has rendered all rungs.
fn whole_seeds(runs: &[Run], name: &str, settings: &Settings) -> BTreeSet<u32> {
    let has = |seed: u32, rung: usize| run(runs, name, seed, rung).is_some();
    (0..settings.seeds).filter(|seed| (0..settings.ladder.count()).all(|rung| has(*seed, rung))).collect()
}

fn run<'a>(runs: &'a [Run], name: &str, seed: u32, rung: usize) -> Option<&'a Run> {
    runs.iter().find(|r| r.renderer == name && r.seed == seed && r.rung == rung)
}

/// The rungs of one renderer, with these seeds, for which all are rendered.
fn rungs(runs: &[Run], name: &str, seeds: &BTreeSet<u32>, settings: &Settings, error: Measure) -> Vec<Rung> {
    let rung = |rung: usize| {
        let all: Vec<&Run> = seeds.iter().filter_map(|seed| run(runs, name, *seed, rung)).collect();
        let fewer = all.iter().map(|r| r.without.len()).min().unwrap_or(0);
        let without = |picture: usize| all.iter().map(|r| error(&r.without[picture])).collect();
        Some(Rung {
            without: (0..fewer).map(without).collect(),
            samples: all.first()?.samples,
            errors: all.iter().map(|r| error(&r.errors)).collect(),
            seconds: all.iter().map(|r| r.took.counted(settings.processor_time)).collect(),
        })
    };
    (0..settings.ladder.count()).filter_map(rung).collect()
}

/// The results of each of the named renderers that has rendered; the others are compared with the first.
/// Error: a reference picture that cannot be read.
pub fn lines(bench: &Bench, names: &[&str], runs: &[Run]) -> Result<Vec<Line>, String> {
    let settings = bench.settings;
    let (trimmed, whole): (Measure, Measure) = (|e| e.trimmed, |e| e.relative_mse);
    let seeds_of = |name: &str| whole_seeds(runs, name, settings);
    let firsts = names.first().map(|name| (*name, seeds_of(name)));
    let reference_of = |name: &str| mean_of(bench.renderers, name).to_string();
    // By the seeds that both have.
    let over = |name: &str, error: Measure| {
        let (first, seeds) = firsts.as_ref().filter(|(first, _)| *first != name)?;
        let common = seeds & &seeds_of(name);
        let [a, b] = [*first, name].map(|name| rungs(runs, name, &common, settings, error));
        ratio(&a, &b, reference_of(first) == reference_of(name))
    };
    let mut means = BTreeMap::new();
    // Several renderers may share one.
    for name in names.iter().map(|name| reference_of(name)).collect::<BTreeSet<_>>() {
        let found = bench.reference_means(&name)?;
        means.insert(name, found);
    }
    let first_of_all = names.first().map(|name| reference_of(name)).unwrap_or_default();
    let over_first = |of: &str| {
        let [own, first] = [means.get(of)?, means.get(&first_of_all)?];
        if of == first_of_all { None } else { ratio_of_means(own, first) }
    };
    let line = |name: &&str| {
        let seeds = seeds_of(name);
        let of = |error: Measure| rungs(runs, name, &seeds, settings, error);
        let by_trimmed = of(trimmed);
        let first = by_trimmed.first()?;
        let startups: Vec<f64> =
            runs.iter().filter(|r| r.renderer == *name).map(|r| r.took.startup).collect();
        let seed = seed_for(name, 0);
        Some(Line {
            renderer: name.to_string(),
            samples: by_trimmed.iter().map(|r| r.samples).collect(),
            seeds: first.errors.len(),
            mean_over_first: over_first(&reference_of(name)),
            mean_of: reference_of(name),
            brightness: of(|e| e.brightness).last().and_then(mean),
            startup: startups.iter().sum::<f64>() / startups.len() as f64,
            ratio_trimmed: over(name, trimmed),
            ratio_whole: over(name, whole),
            trimmed: curve(&by_trimmed, seed),
            whole: curve(&of(whole), seed),
            median: curve(&of(|e| e.median), seed),
        })
    };
    Ok(names.iter().filter_map(line).collect())
}

/// The named renderers that cannot render the scene, or have no reference, with the reason.
pub fn missing(bench: &Bench, names: &[&str]) -> Result<Vec<(String, String)>, String> {
    let schedule = bench.schedule()?;
    let failed = |name: &str| schedule.get(name)?.clone().err();
    let why = |name: &str| failed(name).or_else(|| failed(mean_of(bench.renderers, name)));
    Ok(names.iter().filter_map(|name| Some((name.to_string(), why(name)?))).collect())
}

impl Line {
    /// What to know before its errors are compared with those of the first renderer.
    pub fn warnings(&self, first: &str) -> Vec<String> {
        let Self { renderer, mean_of, .. } = self;
        let another = self.mean_over_first.filter(|mean| misses(*mean)).map(|mean| {
            format!(
                "{renderer} does not render what {first} renders, or finds other light (its mean is {:.3} times as bright): \
                 errors of each are those against its own mean",
                mean.value
            )
        });
        let biased = self.brightness.filter(|brightness| mean_of != renderer && misses(*brightness)).map(|_| {
            format!(
                "{renderer} is not as bright as the mean of {mean_of} that it is held against: its errors are bias, and not \
                 noise alone"
            )
        });
        another.into_iter().chain(biased).collect()
    }
}

/// The warnings of all lines, which are compared with the first renderer, as HTML.
pub fn warnings(lines: &[Line], first: &str) -> String {
    let told = lines.iter().flat_map(|line| line.warnings(first));
    told.map(|warning| format!("<p class=\"note\">Warning: {}.</p>", escape(&warning))).collect()
}

/// Relative difference of brightness that matters.
const BRIGHTNESS: f64 = 0.01;

/// Whether a brightness differs significantly by more than a hundredth.
pub fn misses(brightness: Measured) -> bool {
    brightness.low > 1.0 + BRIGHTNESS || brightness.high < 1.0 - BRIGHTNESS
}

/// The plots and the table of these results, as HTML.
pub fn curves(lines: &[Line]) -> String {
    fn shown(line: &Line) -> page::Line<'_> {
        page::Line {
            name: &line.renderer,
            trimmed: line.trimmed.as_ref(),
            whole: line.whole.as_ref(),
            ratio_trimmed: line.ratio_trimmed.as_ref(),
            ratio_whole: line.ratio_whole.as_ref(),
            mean_of: &line.mean_of,
            brightness: line.brightness,
            mean_over_first: line.mean_over_first,
            startup: Some(line.startup),
        }
    }
    if lines.is_empty() { String::new() } else { page::curves(&lines.iter().map(shown).collect::<Vec<_>>()) }
}

#[cfg(test)]
mod tests {
    use super::super::Ladder;
    use super::*;
    use crate::renderers::Took;

    #[test]
    fn only_whole_seeds_count() {
        let errors = Errors { relative_mse: 2.0, trimmed: 1.0, median: 0.5, mse: 3.0, brightness: 1.0 };
        let run = |seed, rung| Run {
            renderer: "a".into(),
            seed,
            rung,
            samples: 4,
            took: Took { seconds: 1.0, planning: 0.5, cpu_seconds: 7.0, startup: 0.0 },
            errors,
            without: vec![Errors { trimmed: 0.75, ..errors }; 4],
            with: String::new(),
        };
        let ladder = Ladder::Seconds(vec![1.0, 2.0]);
        let settings = Settings { ladder, seeds: 3, reference: 4.0, threads: 0, processor_time: true };
        let runs = [run(0, 0), run(0, 1), run(1, 0), run(2, 0), run(2, 1)];
        let seeds = whole_seeds(&runs, "a", &settings);
        assert_eq!(seeds, BTreeSet::from([0, 2]));
        let found = rungs(&runs, "a", &BTreeSet::from([2]), &settings, |e| e.trimmed);
        assert_eq!(found.len(), 2);
        assert_eq!((found[1].errors.clone(), found[1].seconds.clone()), (vec![1.0], vec![7.0]));
        assert_eq!(found[1].without, vec![vec![0.75]; 4]);
        assert!(rungs(&runs, "a", &BTreeSet::new(), &settings, |e| e.trimmed).is_empty());
    }
}
