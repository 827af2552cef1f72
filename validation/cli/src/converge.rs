//! `validate converge`: error against run time of any renderers on one scene.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use validation::Verdict;
use validation::converge::{
    Curve, Interval, Picture, Ratio, Reference, Rung, curve, errors, mean, page, ratio, reference,
};
use validation::report::to_json;
use validation::statistics::seed_for;

use crate::console::{check_writable, write};
use crate::renderers::{self, Job, Renderer, Renderers, mean_of};

/// What the command takes.
#[derive(Args)]
pub struct Arguments {
    scene: PathBuf,
    /// May be repeated; the others are compared with the first
    #[arg(long = "renderer", default_values = ["etalon", "mitsuba-llvm_ad_spectral"])]
    renderers: Vec<String>,
    /// Another file of renderers
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Sample counts
    #[arg(long, value_delimiter = ',', default_values = ["4", "16", "64"], value_parser = clap::value_parser!(u32).range(1..))]
    spp: Vec<u32>,
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(3..))]
    seeds: u32,
    /// Samples of each of the four pictures of a reference; eight times the longest rung unless given
    #[arg(long)]
    reference_spp: Option<u32>,
    /// All unless given
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Count the processor's seconds, on a machine that does other things meanwhile
    #[arg(long)]
    processor_time: bool,
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with plots
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// The study, as the command line asks for it.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn std::error::Error>> {
    // Otherwise each renderer would be found to miss it, one after the other.
    if !arguments.scene.is_file() {
        return Err(format!("{}: there is no such file", arguments.scene.display()).into());
    }
    let file = arguments.file.unwrap_or_else(renderers::file);
    let known = renderers::load(&file)?;
    if let Some(name) = arguments.renderers.iter().find(|name| !known.contains_key(*name)) {
        return Err(format!("{} has no renderer {name:?}", file.display()).into());
    }
    check_writable(&[&arguments.json, &arguments.html])?;
    let longest = arguments.spp.iter().max().copied().unwrap_or(1);
    let settings = Settings {
        reference_samples: arguments.reference_spp.unwrap_or(longest.saturating_mul(8)),
        ladder: arguments.spp,
        seeds: arguments.seeds,
        threads: arguments.threads,
        processor_time: arguments.processor_time,
    };
    let folder = std::env::temp_dir().join(format!("etalon-converge-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let chosen = (&known, arguments.renderers.as_slice());
    let study = study(&arguments.scene, chosen, &settings, &folder, |step| eprintln!("{step}"));
    std::fs::remove_dir_all(&folder)?;
    let study = study?;
    write(arguments.json.as_deref(), || Ok(to_json(&study)?))?;
    write(arguments.html.as_deref(), || Ok(study.html()))?;
    print!("{}", study.text());
    match study.renderers.is_empty() {
        true => Err("no renderer rendered the scene".into()),
        false => Ok(Verdict::Equivalent),
    }
}

/// How long to look.
#[derive(Clone, Debug, Serialize)]
pub struct Settings {
    /// Sample counts, each several times the one before.
    pub ladder: Vec<u32>,
    pub seeds: u32,
    /// Samples of each of the [`REFERENCES`] pictures whose mean a renderer is held against.
    pub reference_samples: u32,
    pub threads: usize,
    /// Seconds are those of the processor, not the clock's.
    pub processor_time: bool,
}

/// Pictures of a renderer's reference.
pub const REFERENCES: u32 = 4;

/// Everything that was measured.
#[derive(Serialize)]
pub struct Study {
    pub scene: PathBuf,
    pub settings: Settings,
    pub renderers: Vec<Measured>,
    pub missing: Vec<Missing>,
    /// Efficiency of the first renderer over each other one: by trimmed error, then by the whole.
    pub ratios: Vec<Compared>,
}

/// A renderer that ran.
#[derive(Serialize)]
pub struct Measured {
    pub name: String,
    /// Whose converged mean it was held against.
    pub mean_of: String,
    /// The brightness of its longest pictures over the reference's.
    pub brightness: Option<Interval>,
    /// relMSE without its largest 0.1 %, and the whole.
    pub trimmed: Vec<Rung>,
    pub untrimmed: Vec<Rung>,
    pub trimmed_curve: Option<Curve>,
    pub untrimmed_curve: Option<Curve>,
    /// Mean seconds of starting up.
    pub startup: f64,
}

/// A renderer that did not, and why.
#[derive(Serialize)]
pub struct Missing {
    pub name: String,
    pub reason: String,
}

/// One comparison; `None` where it has no answer (see [`ratio`]).
#[derive(Serialize)]
pub struct Compared {
    pub of: String,
    pub over: String,
    pub trimmed: Option<Ratio>,
    pub untrimmed: Option<Ratio>,
}

struct Runner<'a> {
    renderer: &'a Renderer,
    reference: &'a Reference,
    measured: Measured,
    /// Of each longest picture, over the reference's.
    brightness: Vec<f64>,
}

/// Runs the study of the renderers of these names. `progress` hears of each step. Fails if a renderer fails
/// after it has once succeeded.
pub fn study(
    scene: &Path,
    (known, names): (&Renderers, &[String]),
    settings: &Settings,
    folder: &Path,
    progress: impl Fn(&str),
) -> Result<Study, String> {
    let out = folder.join("picture.exr");
    let render = |renderer: &Renderer, samples: u32, seed: u32| -> Result<(Picture, f64, f64), String> {
        let found = renderer.render(&Job { scene, samples, seed, threads: settings.threads }, &out)?;
        let seconds = if settings.processor_time { found.took.cpu_seconds } else { found.took.seconds };
        Ok((found.picture, seconds, found.took.startup))
    };
    let mut references: BTreeMap<&str, Result<Reference, String>> = BTreeMap::new();
    for name in names.iter().map(|name| mean_of(known, name)) {
        if !references.contains_key(name) {
            progress(&format!("{name}: reference"));
            let one = |k| Ok(render(&known[name], settings.reference_samples, seed("reference", k))?.0);
            let pictures: Result<Vec<Picture>, String> = (0..REFERENCES).map(one).collect();
            let found = pictures.and_then(|p| reference(&p).ok_or("its pictures differ in size".to_string()));
            references.insert(name, found);
        }
    }
    let (mut runners, mut missing) = (vec![], vec![]);
    for name in names {
        let (renderer, of) = (&known[name], mean_of(known, name));
        let found = match &references[of] {
            // It has not rendered anything yet: does it at all?
            Ok(reference) if of != name => render(renderer, 1, seed("trial", 0)).map(|_| reference),
            Ok(reference) => Ok(reference),
            Err(reason) => Err(reason.clone()),
        };
        match found {
            Ok(reference) => {
                let empty = || settings.ladder.iter().map(|&samples| rung(samples)).collect();
                let measured = Measured {
                    name: name.clone(),
                    mean_of: of.to_string(),
                    brightness: None,
                    trimmed: empty(),
                    untrimmed: empty(),
                    trimmed_curve: None,
                    untrimmed_curve: None,
                    startup: 0.0,
                };
                runners.push(Runner { renderer, reference, measured, brightness: vec![] });
            }
            Err(reason) => {
                progress(&format!("{name}: missing: {reason}"));
                missing.push(Missing { name: name.clone(), reason });
            }
        }
    }
    let longest = settings.ladder.iter().max();
    // A B A B: whatever the machine does meanwhile, it does to all.
    for k in 0..settings.seeds {
        for (step, &samples) in settings.ladder.iter().enumerate() {
            for runner in &mut runners {
                let name = &runner.measured.name;
                progress(&format!("{name}: seed {} of {}, {samples} spp", k + 1, settings.seeds));
                let (picture, seconds, startup) = render(runner.renderer, samples, seed("picture", k))?;
                if picture.len() != runner.reference.mean.len() {
                    return Err(format!("{name}: its pictures differ in size"));
                }
                let found = errors(&picture, runner.reference);
                if Some(&samples) == longest {
                    runner.brightness.push(found.brightness);
                }
                runner.measured.startup +=
                    startup / (settings.ladder.len() as f64 * f64::from(settings.seeds));
                for (rungs, error) in [
                    (&mut runner.measured.trimmed, found.trimmed),
                    (&mut runner.measured.untrimmed, found.relative_mse),
                ] {
                    rungs[step].errors.push(error);
                    rungs[step].seconds.push(seconds);
                }
            }
        }
    }
    let mut renderers = vec![];
    for Runner { mut measured, brightness, .. } in runners {
        measured.brightness = mean(&brightness);
        measured.trimmed_curve = curve(&measured.trimmed, seed_for(&measured.name, 0));
        measured.untrimmed_curve = curve(&measured.untrimmed, seed_for(&measured.name, 0));
        renderers.push(measured);
    }
    let ratios = renderers.split_first().map_or(vec![], |(first, others)| {
        let compared = others.iter().map(|other| Compared {
            of: first.name.clone(),
            over: other.name.clone(),
            trimmed: ratio(&first.trimmed, &other.trimmed),
            untrimmed: ratio(&first.untrimmed, &other.untrimmed),
        });
        compared.collect()
    });
    Ok(Study { scene: scene.into(), settings: settings.clone(), renderers, missing, ratios })
}

fn rung(samples: u32) -> Rung {
    Rung { samples, errors: vec![], seconds: vec![] }
}

/// Seeds of pictures and references never meet; renderers of 31-bit seeds can take them.
pub(crate) fn seed(what: &str, number: u32) -> u32 {
    (seed_for(what, u64::from(number)) >> 33) as u32
}

impl Study {
    /// A few lines for a terminal: slopes, and the first renderer's efficiency over the others'.
    pub fn text(&self) -> String {
        let slope = |m: &Measured| m.trimmed_curve.as_ref().and_then(|c| c.slope);
        let slopes = self.renderers.iter().filter_map(|m| Some((m, slope(m)?)));
        let slopes =
            slopes.map(|(m, s)| format!("{}: slope {:.3} [{:.3}, {:.3}]", m.name, s.value, s.low, s.high));
        let ratios = self.ratios.iter().flat_map(|c| {
            [("trimmed", &c.trimmed), ("whole", &c.untrimmed)].map(|(what, found)| match found {
                None => format!("{} over {}, {what}: no answer", c.of, c.over),
                Some(Ratio { ratio: r, p_value, .. }) => format!(
                    "{} over {}, {what}: {:.3} [{:.3}, {:.3}] times as efficient, p = {p_value:.1e}",
                    c.of, c.over, r.value, r.low, r.high
                ),
            })
        });
        let brightness = self.renderers.iter().filter_map(|m| Some((m, m.brightness?)));
        let brightness = brightness.map(|(m, b)| {
            format!(
                "{}: {:.4} [{:.4}, {:.4}] times as bright as {}'s mean",
                m.name, b.value, b.low, b.high, m.mean_of
            )
        });
        let missing = self.missing.iter().map(|m| format!("{}: missing: {}", m.name, m.reason));
        slopes.chain(brightness).chain(ratios).chain(missing).map(|line| line + "\n").collect()
    }

    /// The page with plots and tables.
    pub fn html(&self) -> String {
        let of = |name: &str, which: fn(&Compared) -> Option<&Ratio>| {
            self.ratios.iter().find(|c| c.over == name).and_then(which)
        };
        let lines: Vec<page::Line> = self
            .renderers
            .iter()
            .map(|m| page::Line {
                name: &m.name,
                trimmed: m.trimmed_curve.as_ref(),
                whole: m.untrimmed_curve.as_ref(),
                ratio_trimmed: of(&m.name, |c| c.trimmed.as_ref()),
                ratio_whole: of(&m.name, |c| c.untrimmed.as_ref()),
                mean_of: &m.mean_of,
                brightness: m.brightness,
                startup: Some(m.startup),
            })
            .collect();
        let missing: Vec<(&str, &str)> =
            self.missing.iter().map(|m| (m.name.as_str(), m.reason.as_str())).collect();
        let scene = validation::html::escape(&self.scene.to_string_lossy());
        let about = format!("<p>{scene}; brackets and bands are 95 % intervals.</p>");
        page::frame("Error against run time", &(about + &page::curves(&lines) + &page::missing(&missing)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    #[test]
    fn a_scene_that_does_not_exist_is_no_fault_of_a_renderer() {
        let line = Line::parse_from(["converge", "gone.xml"]);
        let error = run(line.arguments).map(|_| ()).unwrap_err().to_string();
        assert_eq!(error, "gone.xml: there is no such file");
    }
}
