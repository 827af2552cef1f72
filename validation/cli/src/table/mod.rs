//! `validate table`: error against run time of every renderer on every scene of `validation/table.toml`.
//!
//! [`plan`] lists scenes and renderers, [`study`](crate::study) renders them into a folder, [`summary`] reads
//! the folder, and [`sheet`] draws the page.

pub mod plan;
pub mod sheet;
pub mod summary;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use clap::Args;
use validation::Verdict;
use validation::report::to_json;

use crate::console::positive_seconds;
use crate::report::machine;
use crate::study::bench::Bench;
use crate::study::{Ladder, Settings};
use crate::{console, files, renderers};
use plan::Entry;
use summary::Table;

/// The arguments of the command.
#[derive(Args)]
pub struct Arguments {
    /// Only these scenes
    names: Vec<String>,
    /// Where everything is kept; a run that was stopped goes on from there
    #[arg(long, default_value = "target/table")]
    folder: PathBuf,
    /// Only these renderers; ours is always one
    #[arg(long = "renderer")]
    chosen: Vec<String>,
    /// Seconds of each rung
    #[arg(long, value_delimiter = ',', value_name = "N,N,…", default_value = "1,4,16", value_parser = positive_seconds)]
    seconds: Vec<Duration>,
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(3..))]
    seeds: u32,
    /// Samples of each of the four pictures of a reference, over those of the longest rung
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
    reference: u32,
    /// Number of threads; all unless given
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Count the processor's seconds, on a machine that does other things meanwhile
    #[arg(long)]
    processor_time: bool,
    /// Seconds that one picture may take; a renderer that takes longer is missing
    #[arg(long, value_name = "SECONDS", value_parser = positive_seconds)]
    timeout: Option<Duration>,
    /// The folder of the scenes that are no part of the repository, which are missing without it
    #[arg(long, value_name = "FOLDER")]
    shared: Option<PathBuf>,
    /// Another file of renderers
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Another plan
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Render nothing: write the outputs from what is there
    #[arg(long)]
    report_only: bool,
}

/// Measures what is missing and writes `table.json`, `table.md`, `table.svg` and `table.html` into the
/// folder, after every scene.
pub fn run(arguments: &Arguments) -> Result<Verdict, Box<dyn std::error::Error>> {
    let known = renderers::load(&arguments.file.clone().unwrap_or_else(renderers::file))?;
    let mut plan = plan::load(&arguments.plan.clone().unwrap_or_else(plan::file))?;
    let wanted = |name: &String, names: &[String]| names.is_empty() || names.contains(name);
    console::all_known("scene", &arguments.names, plan.scene.iter().map(|entry| entry.name.as_str()))?;
    console::all_known("renderer", &arguments.chosen, plan.renderers().map(String::as_str))?;
    plan.scene.retain(|entry| wanted(&entry.name, &arguments.names));
    for group in [&mut plan.mitsuba, &mut plan.others] {
        group.retain(|name| wanted(name, &arguments.chosen));
    }
    let mut seconds: Vec<f64> = arguments.seconds.iter().map(Duration::as_secs_f64).collect();
    seconds.sort_by(f64::total_cmp);
    let settings = kept_settings(
        &arguments.folder,
        Settings {
            ladder: Ladder::Seconds(seconds),
            seeds: arguments.seeds,
            reference: f64::from(arguments.reference),
            threads: arguments.threads,
            processor_time: arguments.processor_time,
        },
        arguments.report_only,
    )?;
    let mut table = Table {
        machine: machine::here().into_iter().map(|(name, value)| (name.to_string(), value)).collect(),
        settings: settings.clone(),
        ours: plan.ours.clone(),
        scenes: vec![],
    };
    let mut pages = vec![];
    for entry in &plan.scene {
        let folder = std::path::absolute(arguments.folder.join(&entry.name))?;
        let scene = folder.join("scene.xml");
        let limit = arguments.timeout;
        let bench = Bench { scene, folder, renderers: &known, settings: &settings, limit };
        let names: Vec<&str> = plan.renderers().map(String::as_str).collect();
        let failed = if arguments.report_only {
            vec![]
        } else {
            let progress = |step: &str| eprintln!("{}: {step}", entry.name);
            let prepared = prepare(entry, arguments.shared.as_deref(), &bench);
            let measured = prepared.and_then(|()| bench.measure(&names, &progress));
            measured.unwrap_or_else(|why| vec![("all".to_owned(), why)])
        };
        let scene = summary::scene(entry, &plan, &bench, failed)?;
        pages.push(sheet::section(&scene, &bench, &plan.ours)?);
        table.scenes.push(scene);
        write(&arguments.folder, &table, &pages)?;
    }
    console::say(format_args!("{}", table.markdown().trim_end()));
    let measured = table.scenes.iter().any(|scene| !scene.lines.is_empty());
    Ok(if measured { Verdict::Equivalent } else { Verdict::Inconclusive })
}

/// Writes the scene file that all renderers render.
fn prepare(entry: &Entry, shared: Option<&Path>, bench: &Bench) -> Result<(), String> {
    let source = entry.path(shared)?;
    if !source.is_file() {
        return Err(format!("there is no {}", source.display()));
    }
    std::fs::create_dir_all(&bench.folder).map_err(|e| format!("{}: {e}", bench.folder.display()))?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers/prepare_scene.py");
    let size = format!("{}x{}", entry.size[0], entry.size[1]);
    let mut command = Command::new("python3");
    command.arg(script).arg(source).arg(&bench.scene).args([&size, &entry.filter]);
    let output = command.output().map_err(|e| format!("python3: {e}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() { Ok(()) } else { Err(said.lines().last().unwrap_or("").to_string()) }
}

/// The settings of the folder: those given, which are stored there at first. Error: they differ from those of
/// its pictures, other than by more seeds.
fn kept_settings(
    folder: &Path,
    given: Settings,
    report_only: bool,
) -> Result<Settings, Box<dyn std::error::Error>> {
    let file = folder.join("settings.json");
    if file.is_file() {
        let kept: Settings = files::json(&file)?;
        let same = Settings { seeds: given.seeds, ..kept.clone() } == given;
        return match (report_only, same) {
            (true, _) => Ok(kept),
            // A run with more seeds continues one with fewer.
            (false, true) if given.seeds >= kept.seeds => {
                console::write(Some(&file), || Ok(to_json(&given)?))?;
                Ok(given)
            }
            _ => Err(format!(
                "{} holds pictures of other settings, as {} says; choose another --folder",
                folder.display(),
                file.display()
            )
            .into()),
        };
    }
    if report_only {
        return Err(format!("{} holds no pictures to report on", folder.display()).into());
    }
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    console::write(Some(&file), || Ok(to_json(&given)?))?;
    Ok(given)
}

fn write(folder: &Path, table: &Table, pages: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    console::write(Some(&folder.join("table.json")), || Ok(to_json(table)?))?;
    console::write(Some(&folder.join("table.md")), || Ok(table.markdown()))?;
    console::write(Some(&folder.join("table.svg")), || Ok(table.drawing()))?;
    console::write(Some(&folder.join("table.html")), || Ok(sheet::page(table, pages)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_keeps_its_settings() {
        let folder = std::env::temp_dir().join(format!("etalon-table-{}", std::process::id()));
        let settings = |seeds: u32, seconds: f64| Settings {
            ladder: Ladder::Seconds(vec![seconds]),
            seeds,
            reference: 4.0,
            threads: 0,
            processor_time: false,
        };
        let ask = |seeds, seconds, only| kept_settings(&folder, settings(seeds, seconds), only);
        // Nothing is settled by a report on nothing.
        assert!(ask(4, 2.0, true).is_err() && !folder.exists());
        assert!(ask(4, 1.0, false).is_ok());
        assert!(ask(8, 1.0, false).is_ok_and(|s| s.seeds == 8));
        assert!(ask(4, 1.0, false).is_err() && ask(8, 2.0, false).is_err());
        assert!(ask(3, 2.0, true).is_ok_and(|s| s == settings(8, 1.0)));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
