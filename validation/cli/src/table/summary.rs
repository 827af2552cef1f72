//! The results of the table: curves, ratios and whether the ratios that are aimed at are reached.

use std::collections::BTreeSet;
use std::fmt::Write;

use serde::Serialize;
use validation::converge::forest::{Mark, Row, forest};
use validation::converge::{Measured, Ratio};

use super::plan::{Entry, Plan};
use crate::study::Settings;
use crate::study::bench::Bench;
use crate::study::line::{Line, lines, misses, missing};

/// The whole table.
#[derive(Serialize)]
pub struct Table {
    pub machine: Vec<(String, String)>,
    pub settings: Settings,
    pub ours: String,
    pub scenes: Vec<Scene>,
}

/// The results of one scene.
#[derive(Serialize)]
pub struct Scene {
    pub name: String,
    pub class: String,
    pub size: [u32; 2],
    /// Results of the renderers that rendered.
    pub lines: Vec<Line>,
    /// Renderers that could not render, with the reason.
    pub missing: Vec<(String, String)>,
    /// The commits and machines with which the pictures were rendered.
    pub with: BTreeSet<String>,
    /// Our efficiency over that of the best Mitsuba variant, and over that of the best other renderer.
    pub against: Vec<Against>,
}

/// A comparison with a baseline, the renderer with the largest efficiency of a group.
#[derive(Serialize)]
pub struct Against {
    pub group: String,
    /// The best renderer by trimmed error, and our efficiency over its.
    pub best_trimmed: Option<(String, Ratio)>,
    /// The best renderer by untrimmed error, and our efficiency over its.
    pub best_whole: Option<(String, Ratio)>,
    /// The ratio that is aimed at.
    pub aim: f64,
    /// By trimmed error.
    pub standing: Standing,
}

/// Whether an aim is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Standing {
    /// The whole interval is at or above the aim.
    Reached,
    /// The whole interval is below the aim.
    Missed,
    /// Neither; or a renderer's brightness differs from its reference, because errors then compare bias with
    /// noise; or a renderer of the group has no ratio, because it may be the best.
    Open,
    /// There is no ratio at all.
    #[serde(rename = "no answer")]
    NoAnswer,
}

impl std::fmt::Display for Standing {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.pad(match self {
            Self::Reached => "reached",
            Self::Missed => "missed",
            Self::Open => "open",
            Self::NoAnswer => "no answer",
        })
    }
}

/// The results of a scene so far; `failed` says which renderers were not measured to the end, and why.
pub fn scene(
    entry: &Entry,
    plan: &Plan,
    bench: &Bench,
    failed: Vec<(String, String)>,
) -> Result<Scene, String> {
    let names: Vec<&str> = plan.renderers().map(String::as_str).collect();
    let runs = bench.runs()?;
    let lines = lines(bench, &names, &runs)?;
    let with = runs.into_iter().map(|run| run.with).collect();
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
        let unknown = lines.iter().any(|line| names.contains(&line.renderer) && line.ratio_trimmed.is_none());
        let standing = standing(best_trimmed.as_ref().map(|b| &b.1), aim, biased || unknown);
        Against {
            group: group.into(),
            best_whole: best(|line| line.ratio_whole),
            best_trimmed,
            aim,
            standing,
        }
    };
    let aims = class.map_or([1.0; 2], |c| [c.mitsuba, c.others]);
    let against = vec![group("Mitsuba", &plan.mitsuba, aims[0]), group("others", &plan.others, aims[1])];
    let missing = failed.into_iter().chain(missing(bench, &names)?).collect();
    let title = class.map_or_else(|| entry.class.clone(), |c| c.title.clone());
    Ok(Scene { name: entry.name.clone(), class: title, size: entry.size, lines, missing, with, against })
}

fn standing(found: Option<&Ratio>, aim: f64, doubtful: bool) -> Standing {
    match found {
        None => Standing::NoAnswer,
        Some(_) if doubtful => Standing::Open,
        Some(found) if found.ratio.low >= aim => Standing::Reached,
        Some(found) if found.ratio.high < aim => Standing::Missed,
        Some(_) => Standing::Open,
    }
}

impl Against {
    /// The best renderer by trimmed error.
    pub fn name(&self) -> &str {
        self.best_trimmed.as_ref().map_or("–", |(name, _)| name)
    }

    /// The ratios to the best renderer by trimmed and by untrimmed error, formatted by `show`; the second has
    /// the renderer's name if it is another one.
    pub fn ratios(&self, show: impl Fn(&Measured) -> String) -> [String; 2] {
        let cell = |best: &Option<(String, Ratio)>| match best {
            None => "–".to_string(),
            Some((name, found)) if name == self.name() => show(&found.ratio),
            Some((name, found)) => format!("{} ({name})", show(&found.ratio)),
        };
        [cell(&self.best_trimmed), cell(&self.best_whole)]
    }
}

impl Table {
    /// The commits and machines of all pictures; times are comparable if there is only one.
    pub fn with(&self) -> BTreeSet<&str> {
        self.scenes.iter().flat_map(|scene| &scene.with).map(String::as_str).collect()
    }

    /// The forest plot of the ratios by trimmed error, with the aims.
    pub fn drawing(&self) -> String {
        let groups = self.scenes.first().map_or(vec![], |scene| {
            scene.against.iter().map(|against| format!("over the best of {}", against.group)).collect()
        });
        let groups: Vec<&str> = groups.iter().map(String::as_str).collect();
        let mark = |against: &Against| Mark {
            ratio: against.best_trimmed.as_ref().map(|(_, found)| found.ratio),
            aim: against.aim,
        };
        let row = |scene| {
            let Scene { name, against, .. }: &Scene = scene;
            Row { name, marks: against.iter().map(mark).collect() }
        };
        let rows: Vec<Row> = self.scenes.iter().map(row).collect();
        forest(&groups, &rows, "how many times less squared error in equal time; strokes are aims")
    }

    /// The table as Markdown, with a row for each scene.
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "How many times less relMSE {} makes in equal time ({}), without the 0.1 % largest values and \
             with them; brackets are 95 % intervals.\n\n| class | scene | best Mitsuba | trimmed | whole | aim | best other | \
             trimmed | whole | aim |\n|---|---|---|--:|--:|---|---|--:|--:|---|\n",
            self.ours,
            self.settings.words()
        );
        for scene in &self.scenes {
            let mut row = format!("| {} | {} |", scene.class, scene.name);
            for against in &scene.against {
                let digits = |v: f64| if v >= 10.0 { format!("{v:.0}") } else { format!("{v:.2}") };
                let [trimmed, whole] = against.ratios(|ratio| {
                    format!("{} [{}, {}]", digits(ratio.value), digits(ratio.low), digits(ratio.high))
                });
                let Against { aim, standing, .. } = against;
                // Writing to a String cannot fail.
                let _written = write!(row, " {} | {trimmed} | {whole} | {aim}: {standing} |", against.name());
            }
            text += &(row + "\n");
        }
        text.push('\n');
        for (fact, value) in &self.machine {
            text += &format!("- {fact}: {value}\n");
        }
        for with in self.with() {
            text += &format!("- rendered with: {with}\n");
        }
        let lines = self.scenes.iter().flat_map(|s| s.lines.iter().map(move |line| (s, line)));
        for (scene, line) in lines {
            for warning in line.warnings(&self.ours) {
                text += &format!("- warning: {}: {warning}\n", scene.name);
            }
        }
        let missing = self.scenes.iter().flat_map(|s| s.missing.iter().map(move |m| (s, m)));
        missing.fold(text, |text, (s, (name, why))| text + &format!("- missing: {}, {name}: {why}\n", s.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::converge::{Rung, ratio};

    #[test]
    fn the_standing_follows_the_interval() {
        let three = |cost: f64| {
            vec![Rung {
                samples: 1,
                errors: vec![cost, 1.1 * cost, 0.9 * cost],
                seconds: vec![1.0; 3],
                ..Rung::default()
            }]
        };
        let found = ratio(&three(1.0), &three(5.0), false).unwrap();
        let of = |aim: f64, doubtful: bool| standing(Some(&found), aim, doubtful);
        assert_eq!([of(4.9, false), of(5.1, false)], [Standing::Reached, Standing::Missed]);
        assert_eq!([standing(None, 1.0, false), of(4.9, true)], [Standing::NoAnswer, Standing::Open]);
        let brightness = |value: f64| Measured { value, low: value - 0.01, high: value + 0.01 };
        assert_eq!(
            [0.97, 0.985, 1.0, 1.03].map(|value| misses(brightness(value))),
            [true, false, false, true]
        );
    }
}
