//! `validate converge`: error against run time of any renderers on one scene.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use validation::Verdict;
use validation::converge::page::show;
use validation::converge::{Measured, Ratio, page};
use validation::html::escape;
use validation::report::to_json;

use crate::console::{all_known, check_writable, positive_seconds, say, write};
use crate::renderers;
use crate::study::bench::Bench;
use crate::study::line::{Line, curves, lines, missing, warnings};
use crate::study::pictures::pictures;
use crate::study::{Ladder, Run, Settings};

/// The arguments of the command.
#[derive(Args)]
pub struct Arguments {
    /// The scene that all of them render
    scene: PathBuf,
    /// May be repeated; the others are compared with the first
    #[arg(long = "renderer", default_values = ["etalon", "mitsuba-llvm_ad_spectral"])]
    renderers: Vec<String>,
    /// Another file of renderers
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Sample counts
    #[arg(long, value_delimiter = ',', value_name = "N,N,…", default_value = "4,16,64", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Vec<u32>,
    /// Pictures of each sample count: at least three, for an interval
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(3..))]
    seeds: u32,
    /// Samples of each of the four pictures of a reference; eight times the longest rung unless given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    reference_spp: Option<u32>,
    /// Number of threads; all unless given
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Count the processor's seconds, on a machine that does other things meanwhile
    #[arg(long)]
    processor_time: bool,
    /// Seconds that one picture may take; a renderer that takes longer is missing
    #[arg(long, value_name = "SECONDS", value_parser = positive_seconds)]
    timeout: Option<Duration>,
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with plots
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// The study that the command line describes.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn std::error::Error>> {
    // Otherwise each renderer would report the missing file, one after the other.
    if !arguments.scene.is_file() {
        return Err(format!("{}: there is no such file", arguments.scene.display()).into());
    }
    let file = arguments.file.unwrap_or_else(renderers::file);
    let known = renderers::load(&file)?;
    all_known("renderer", &arguments.renderers, known.keys().map(String::as_str))?;
    let twice = |(i, name): (usize, &String)| arguments.renderers[..i].contains(name);
    if let Some((_, name)) = arguments.renderers.iter().enumerate().find(|of| twice(*of)) {
        return Err(format!("the renderer {name:?} is named twice").into());
    }
    check_writable(&[&arguments.scene, &file], &[&arguments.json, &arguments.html])?;
    let mut samples = arguments.spp;
    samples.sort_unstable();
    if let Some(pair) = samples.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("--spp has {} twice", pair[0]).into());
    }
    let longest = samples.last().copied().unwrap_or(1);
    let settings = Settings {
        reference: arguments.reference_spp.map_or(8.0, |spp| f64::from(spp) / f64::from(longest)),
        ladder: Ladder::Samples(samples),
        seeds: arguments.seeds,
        threads: arguments.threads,
        processor_time: arguments.processor_time,
    };
    let folder = tempfile::tempdir()?;
    let bench = Bench {
        scene: arguments.scene,
        folder: folder.path().to_owned(),
        renderers: &known,
        settings: &settings,
        limit: arguments.timeout,
    };
    let names: Vec<&str> = arguments.renderers.iter().map(String::as_str).collect();
    tell(&bench, &names, arguments.json.as_deref(), arguments.html.as_deref())
}

/// Measures, and writes the results while the pictures exist.
fn tell(
    bench: &Bench,
    names: &[&str],
    json: Option<&Path>,
    html: Option<&Path>,
) -> Result<Verdict, Box<dyn std::error::Error>> {
    let study = study(bench, names)?;
    write(json, || Ok(to_json(&study)?))?;
    write(html, || Ok(study.html(bench)?))?;
    say(format_args!("{}", study.text().trim_end()));
    match (study.lines.is_empty(), study.missing.is_empty()) {
        (true, _) => Err("no renderer rendered the scene".into()),
        (false, true) => Ok(Verdict::Equivalent),
        // What was asked for has not been compared.
        (false, false) => Ok(Verdict::Inconclusive),
    }
}

/// All results of a study.
#[derive(Serialize)]
struct Study {
    scene: PathBuf,
    settings: Settings,
    /// The renderer that all others are compared with.
    first: String,
    /// Results of the renderers that rendered, with the ratio of the first one's efficiency to each.
    lines: Vec<Line>,
    /// Renderers that could not render, or failed later, with the reason.
    missing: Vec<(String, String)>,
    /// Error and time of every picture.
    runs: Vec<Run>,
}

/// Runs the study.
fn study(bench: &Bench, names: &[&str]) -> Result<Study, String> {
    let failed = bench.measure(names, &|step| eprintln!("{step}"))?;
    let runs = bench.runs()?;
    Ok(Study {
        scene: bench.scene.clone(),
        settings: bench.settings.clone(),
        lines: lines(bench, names, &runs)?,
        missing: missing(bench, names)?.into_iter().chain(failed).collect(),
        first: names.first().map_or_else(String::new, ToString::to_string),
        runs,
    })
}

impl Study {
    /// Lines for a terminal: errors and times of each rung, slopes, brightness, and the first renderer's
    /// efficiency over the others'.
    fn text(&self) -> String {
        let told = self.lines.iter().flat_map(|line| rungs(line).into_iter().chain(about(line)));
        let first = &self.first;
        let rendered = self.lines.first().is_some_and(|line| line.renderer == *first);
        let alone =
            (!rendered).then(|| format!("no ratios: {first}, which all are compared with, is missing"));
        let ratios = self.lines.iter().filter(|l| rendered && l.renderer != *first).flat_map(|l| {
            [("trimmed", &l.ratio_trimmed), ("whole", &l.ratio_whole)].map(|(what, found)| match found {
                None => format!("{first} over {}, {what}: no answer", l.renderer),
                Some(Ratio { ratio, p_value, .. }) => format!(
                    "{first} over {}, {what}: {} times as efficient, p = {p_value:.1e}",
                    l.renderer,
                    show(*ratio)
                ),
            })
        });
        let warnings = self.lines.iter().flat_map(|line| line.warnings(first));
        let warnings = warnings.map(|warning| format!("warning: {warning}"));
        let missing = self.missing.iter().map(|(name, why)| format!("{name}: missing: {why}"));
        told.chain(ratios).chain(warnings).chain(alone).chain(missing).map(|line| line + "\n").collect()
    }

    /// The page with plots, tables and pictures.
    fn html(&self, bench: &Bench) -> Result<String, String> {
        let names: Vec<String> = self.lines.iter().map(|line| line.renderer.clone()).collect();
        let body = [
            format!(
                "<p>{}: {}; brackets and bands are 95 % intervals.</p>",
                escape(&self.scene.to_string_lossy()),
                self.settings.words()
            ),
            curves(&self.lines),
            warnings(&self.lines, &self.first),
            pictures(&names, &self.lines, bench)?,
            page::missing(&self.missing),
        ];
        Ok(page::frame("Error against run time", &body.concat()))
    }
}

/// The error and the seconds of each rung.
fn rungs(line: &Line) -> Vec<String> {
    let (Some(trimmed), Some(whole)) = (&line.trimmed, &line.whole) else { return vec![] };
    let rung = |(i, samples): (usize, &u32)| {
        format!(
            "{}: {samples} samples: relMSE {} trimmed, {} whole, in {} s",
            line.renderer,
            show(trimmed.errors[i]),
            show(whole.errors[i]),
            show(trimmed.seconds[i])
        )
    };
    line.samples.iter().enumerate().map(rung).collect()
}

/// How a renderer's error falls, and how bright its pictures and its reference are.
fn about(line: &Line) -> Vec<String> {
    let Line { renderer, mean_of, .. } = line;
    let slope = line.trimmed.as_ref().and_then(|curve| curve.slope);
    let slope = slope.map(|s| format!("{renderer}: slope {:.3} [{:.3}, {:.3}]", s.value, s.low, s.high));
    let times = |what: &str, than: &str, found: Option<Measured>| {
        let Measured { value, low, high } = found?;
        Some(format!("{what}: {value:.4} [{low:.4}, {high:.4}] times as bright as {than}"))
    };
    let pictures = times(renderer, &format!("{mean_of}'s mean"), line.brightness);
    let mean = times(&format!("{mean_of}'s mean"), "the first renderer's", line.mean_over_first);
    [slope, pictures, mean].into_iter().flatten().collect()
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
