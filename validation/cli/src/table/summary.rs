//! What the pictures of the table say: curves, ratios and whether the ratios that are aimed at are reached.

use std::fmt::Write;

use serde::Serialize;
use validation::converge::{Curve, Errors, Interval, Ratio, Rung, curve, mean, ratio};
use validation::statistics::seed_for;

use super::measure::{Bench, Run, Schedule, Settings};
use super::plan::{Entry, Plan};
use crate::renderers::mean_of;

/// The whole table.
#[derive(Serialize)]
pub struct Table {
    pub machine: Vec<(String, String)>,
    pub settings: Settings,
    pub ours: String,
    pub scenes: Vec<Scene>,
}

/// One scene.
#[derive(Serialize)]
pub struct Scene {
    pub name: String,
    pub class: String,
    pub size: [u32; 2],
    /// Who rendered.
    pub lines: Vec<Line>,
    /// Who did not, and why.
    pub missing: Vec<(String, String)>,
    /// Our efficiency over that of the best Mitsuba variant, and of the best of the others.
    pub against: Vec<Against>,
}

/// A renderer that ran.
#[derive(Serialize)]
pub struct Line {
    pub renderer: String,
    pub samples: Vec<u32>,
    pub seeds: usize,
    /// Whose converged mean it was held against.
    pub mean_of: String,
    /// The brightness of its longest pictures over the reference's.
    pub brightness: Option<Interval>,
    pub startup: f64,
    pub trimmed: Option<Curve>,
    pub whole: Option<Curve>,
    pub median: Option<Curve>,
    /// Our efficiency over this one's, by trimmed error and by the whole.
    pub ratio_trimmed: Option<Ratio>,
    pub ratio_whole: Option<Ratio>,
}

/// A baseline: the renderer with the largest efficiency of a group.
#[derive(Serialize)]
pub struct Against {
    pub group: String,
    pub best_trimmed: Option<(String, Ratio)>,
    pub best_whole: Option<(String, Ratio)>,
    /// The ratio that is aimed at.
    pub aim: f64,
    /// By trimmed error: `reached` if the whole interval is at or above the aim, `missed` if below, else
    /// `open`; `open` as well if either renderer is not as bright as its reference, for then errors compare
    /// bias with noise.
    pub verdict: String,
}

/// One of the errors.
type Measure = fn(&Errors) -> f64;

/// The rungs of one renderer, of the seeds that have all of them.
fn rungs(runs: &[Run], name: &str, settings: &Settings, error: Measure) -> Vec<Rung> {
    let count = settings.seconds.len();
    let at =
        |seed: u32, rung: usize| runs.iter().find(|r| r.renderer == name && r.seed == seed && r.rung == rung);
    let whole: Vec<Vec<&Run>> = (0..settings.seeds)
        .filter_map(|seed| (0..count).map(|rung| at(seed, rung)).collect::<Option<Vec<_>>>())
        .collect();
    let rung = |rung: usize| Rung {
        samples: whole.first().map_or(0, |first| first[rung].samples),
        errors: whole.iter().map(|seed| error(&seed[rung].errors)).collect(),
        seconds: whole
            .iter()
            .map(|seed| if settings.processor_time { seed[rung].cpu_seconds } else { seed[rung].seconds })
            .collect(),
    };
    if whole.is_empty() { vec![] } else { (0..count).map(rung).collect() }
}

/// What was measured of a scene so far; `failed` is why it was not measured at all.
pub fn scene(entry: &Entry, plan: &Plan, bench: &Bench, failed: Option<String>) -> Result<Scene, String> {
    let (runs, schedule) = (bench.runs()?, bench.schedule()?);
    let of = |name: &str, error: Measure| rungs(&runs, name, bench.settings, error);
    let (trimmed, whole): (Measure, Measure) = (|e| e.trimmed, |e| e.relative_mse);
    let ours = [of(&plan.ours, trimmed), of(&plan.ours, whole)];
    let mut lines = vec![];
    for name in plan.renderers() {
        let [by_trimmed, by_whole] = [of(name, trimmed), of(name, whole)];
        let Some(first) = by_trimmed.first() else { continue };
        let mine: Vec<f64> = runs.iter().filter(|r| &r.renderer == name).map(|r| r.startup).collect();
        let other = name != &plan.ours;
        let seed = seed_for(name, 0);
        lines.push(Line {
            renderer: name.clone(),
            samples: by_trimmed.iter().map(|r| r.samples).collect(),
            seeds: first.errors.len(),
            mean_of: mean_of(bench.renderers, name).to_string(),
            brightness: of(name, |e| e.brightness).last().and_then(|rung| mean(&rung.errors)),
            startup: mine.iter().sum::<f64>() / mine.len() as f64,
            ratio_trimmed: if other { ratio(&ours[0], &by_trimmed) } else { None },
            ratio_whole: if other { ratio(&ours[1], &by_whole) } else { None },
            trimmed: curve(&by_trimmed, seed),
            whole: curve(&by_whole, seed),
            median: curve(&of(name, |e| e.median), seed),
        });
    }
    let class = plan.class.get(&entry.class);
    let group = |group: &str, names: &[String], aim: f64| {
        let best = |of: fn(&Line) -> Option<Ratio>| {
            let found = lines.iter().filter(|line| names.contains(&line.renderer));
            let found = found.filter_map(|line| Some((line.renderer.clone(), of(line)?)));
            found.min_by(|a, b| a.1.ratio.value.total_cmp(&b.1.ratio.value))
        };
        let best_trimmed = best(|line| line.ratio_trimmed);
        let of = |name: &String| lines.iter().find(|line| &line.renderer == name);
        let rivals = best_trimmed.iter().map(|b| &b.0).chain([&plan.ours]).filter_map(of);
        let biased = rivals.filter_map(|line| line.brightness).any(misses);
        let verdict = verdict(best_trimmed.as_ref().map(|b| &b.1), aim, biased).into();
        Against { group: group.into(), best_whole: best(|line| line.ratio_whole), best_trimmed, aim, verdict }
    };
    let aims = class.map_or([1.0; 2], |c| [c.mitsuba, c.others]);
    let against = vec![group("Mitsuba", &plan.mitsuba, aims[0]), group("others", &plan.others, aims[1])];
    let missing = missing(&schedule, failed);
    let title = class.map_or_else(|| entry.class.clone(), |c| c.title.clone());
    Ok(Scene { name: entry.name.clone(), class: title, size: entry.size, lines, missing, against })
}

fn missing(schedule: &Schedule, failed: Option<String>) -> Vec<(String, String)> {
    let all = failed.map(|why| ("all".to_string(), why));
    let refused = schedule.iter().filter_map(|(name, found)| Some((name.clone(), found.clone().err()?)));
    all.into_iter().chain(refused).collect()
}

/// The difference of brightness from which a renderer does not render its reference.
const BRIGHTNESS: f64 = 0.01;

/// Whether a brightness surely differs by more than that.
fn misses(brightness: Interval) -> bool {
    brightness.low > 1.0 + BRIGHTNESS || brightness.high < 1.0 - BRIGHTNESS
}

fn verdict(found: Option<&Ratio>, aim: f64, biased: bool) -> &'static str {
    match found {
        None => "no answer",
        Some(_) if biased => "open",
        Some(found) if found.ratio.low >= aim => "reached",
        Some(found) if found.ratio.high < aim => "missed",
        Some(_) => "open",
    }
}

impl Table {
    /// The table for a document: a row for each scene.
    pub fn markdown(&self) -> String {
        let clock = if self.settings.processor_time { "processor seconds" } else { "seconds" };
        let mut text = format!(
            "How many times less relMSE {} makes in equal time ({clock} of {:?}, {} seeds), without the 0.1 % largest values and \
             with them; brackets are 95 % intervals.\n\n| class | scene | best Mitsuba | trimmed | whole | aim | best other | \
             trimmed | whole | aim |\n|---|---|---|--:|--:|---|---|--:|--:|---|\n",
            self.ours, self.settings.seconds, self.settings.seeds
        );
        for scene in &self.scenes {
            let mut row = format!("| {} | {} |", scene.class, scene.name);
            for against in &scene.against {
                let name = against.best_trimmed.as_ref().map_or("–", |b| &b.0);
                let cell = |best: &Option<(String, Ratio)>| {
                    best.as_ref().map_or("–".to_string(), |(_, r)| {
                        let digits = |v: f64| if v >= 10.0 { format!("{v:.0}") } else { format!("{v:.2}") };
                        format!(
                            "{} [{}, {}]",
                            digits(r.ratio.value),
                            digits(r.ratio.low),
                            digits(r.ratio.high)
                        )
                    })
                };
                let (trimmed, whole) = (cell(&against.best_trimmed), cell(&against.best_whole));
                // Writing to a String cannot fail.
                let _written =
                    write!(row, " {name} | {trimmed} | {whole} | {}: {} |", against.aim, against.verdict);
            }
            text += &(row + "\n");
        }
        text.push('\n');
        for (fact, value) in &self.machine {
            text += &format!("- {fact}: {value}\n");
        }
        let missing = self.scenes.iter().flat_map(|s| s.missing.iter().map(move |m| (s, m)));
        missing.fold(text, |text, (s, (name, why))| text + &format!("- missing: {}, {name}: {why}\n", s.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_seeds_count_and_verdicts_follow_the_interval() {
        let errors = Errors { relative_mse: 2.0, trimmed: 1.0, median: 0.5, mse: 3.0, brightness: 1.0 };
        let run = |seed, rung| Run {
            renderer: "a".into(),
            seed,
            rung,
            samples: 4,
            seconds: 1.0,
            cpu_seconds: 7.0,
            startup: 0.0,
            errors,
        };
        let settings =
            Settings { seconds: vec![1.0, 2.0], seeds: 3, reference: 4, threads: 0, processor_time: true };
        let found = rungs(&[run(0, 0), run(0, 1), run(1, 0)], "a", &settings, |e| e.trimmed);
        assert_eq!(found.len(), 2);
        assert_eq!((found[1].errors.clone(), found[1].seconds.clone()), (vec![1.0], vec![7.0]));
        assert!(rungs(&[run(1, 0)], "a", &settings, |e| e.trimmed).is_empty());

        let three = |cost: f64| {
            vec![Rung { samples: 1, errors: vec![cost, 1.1 * cost, 0.9 * cost], seconds: vec![1.0; 3] }]
        };
        let found = ratio(&three(1.0), &three(5.0)).unwrap();
        assert_eq!([4.9, 5.1].map(|aim| verdict(Some(&found), aim, false)), ["reached", "missed"]);
        assert_eq!((verdict(None, 1.0, false), verdict(Some(&found), 4.9, true)), ("no answer", "open"));
        let brightness = |value: f64| Interval { value, low: value - 0.01, high: value + 0.01 };
        assert_eq!(
            [0.97, 0.985, 1.0, 1.03].map(|value| misses(brightness(value))),
            [true, false, false, true]
        );
    }
}
