//! The command line of the harness: `validate bsdf`, `images`, `scenes`, `museum`.

use clap::Parser;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use validate::console::{percentage, print, say};
use validate::provenance::Made;
use validate::trial::{Trial, effort, effort_of_sampling};
use validate::{
    calibrate, closed_forms, converge, furnace, images, ledger, limits, materials, metamorphic, museum,
    peers, references, report, sampling, stability, table,
};
use validation::checks::Effort;
use validation::report::to_json;
use validation::{Report, Verdict};

/// Judges materials, images and scenes.
///
/// Exit codes: 0 holds, 1 different, 2 bad input, 3 inconclusive.
#[derive(Parser)]
#[command(version)]
enum Command {
    /// All checks on all materials, or on one
    Bsdf {
        /// Only this material; of a peer, configurations whose name contains this
        name: Option<String>,
        /// Judge another program's BSDFs, over the protocol of docs/peer-protocol.md
        #[arg(long, value_name = "COMMAND")]
        peer: Option<String>,
        /// Seconds a peer may take for one answer
        #[arg(long, default_value_t = 60)]
        timeout: u64,
        /// Samples a check
        #[arg(long, default_value_t = 1 << 18)]
        samples: usize,
        /// 10 000 states for `jacobian`, harmonics to degree 8 for `moments`
        #[arg(long)]
        thorough: bool,
        /// Another number, other seeds
        #[arg(long, alias = "seed", default_value_t = 0)]
        number: u64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        /// Append every p-value to a file of JSON lines
        #[arg(long, value_name = "FILE")]
        ledger: Option<PathBuf>,
    },
    /// Error against run time of any renderers of renderers.toml
    Converge(converge::Arguments),
    /// Error against run time of every renderer on every scene of table.toml
    Table(table::Arguments),
    /// Whether comparisons of efficiency find what is there and nothing else
    Calibrate(calibrate::Arguments),
    /// All checks on all else that is drawn: light, lenses, filters, wavelengths, warps
    Sampling {
        /// Only what this is in the name of
        name: Option<String>,
        /// Samples a check
        #[arg(long, default_value_t = 1 << 18)]
        samples: usize,
        /// 10 000 states for `jacobian`, harmonics to degree 8 for `moments`
        #[arg(long)]
        thorough: bool,
        /// Another number, other seeds
        #[arg(long, alias = "seed", default_value_t = 0)]
        number: u64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        /// Append every p-value to a file of JSON lines
        #[arg(long, value_name = "FILE")]
        ledger: Option<PathBuf>,
    },
    /// Energy over roughness, index and angle
    Furnace {
        /// Only what this is in the name of
        name: Option<String>,
        /// Samples an albedo
        #[arg(long, default_value_t = 1 << 18)]
        samples: usize,
        /// Another number, other seeds
        #[arg(long, alias = "seed", default_value_t = 0)]
        number: u64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        /// Write what single scattering loses, and check nothing
        #[arg(long, value_name = "CSV")]
        losses: Option<PathBuf>,
    },
    /// Whether the p-values of a ledger are uniform, and its reseeded runs reject as often as their level says
    Ledger(ledger::command::Arguments),
    /// Whether two images have the same expectation
    Images(images::command::Arguments),
    /// All of it on one page: tables, plots and pictures
    Report {
        #[arg(short, long, value_name = "HTML", default_value = "report.html")]
        output: PathBuf,
        /// Take what the JSON documents of this folder answer from there
        #[arg(long, value_name = "DIR")]
        from: Option<PathBuf>,
        /// Fewer samples and directions, fewer cases and scenes
        #[arg(long)]
        quick: bool,
    },
    /// Stiff and extreme scenes, each with a stated expectation
    Stability {
        /// Only cases whose name contains this
        name: Option<String>,
        /// Ten times the samples, and 10⁸ spawned rays
        #[arg(long)]
        thorough: bool,
        /// Another number, other seeds
        #[arg(long, default_value_t = 0)]
        number: u64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        /// Write the table
        #[arg(long, value_name = "FILE")]
        markdown: Option<PathBuf>,
    },
    /// Etalon against the stored references, closed forms and metamorphic relations
    Scenes {
        /// Only scenes whose name contains this
        name: Option<String>,
        /// Samples a pixel
        #[arg(long, default_value_t = 1024)]
        spp: u32,
        /// Largest relative difference of a channel's mean that is none
        #[arg(long, default_value = "0.5%", value_parser = percentage)]
        margin: f64,
        /// Another number, other seeds
        #[arg(long, default_value_t = 0)]
        number: u64,
        /// 64 times the samples of closed forms; relations four times as fine
        #[arg(long)]
        thorough: bool,
        /// Write the tables of closed forms and relations
        #[arg(long, value_name = "FILE")]
        markdown: Option<PathBuf>,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Whether the tests notice bugs, those of `validation/museum` or mutants
    Museum(museum::command::Arguments),
}

fn main() -> ExitCode {
    match run(Command::parse()) {
        Ok(verdict) => ExitCode::from(verdict.exit_code()),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(command: Command) -> Result<Verdict, Box<dyn Error>> {
    match command {
        Command::Bsdf { name, peer: Some(command), timeout, samples, number, json, .. } => {
            let limit = Duration::from_secs(timeout);
            let settings = peers::Settings { name: name.as_deref(), samples, number, limit };
            finish(peers::run(&command, &settings, print)?, json)
        }
        Command::Bsdf { name, samples, thorough, number, json, ledger, .. } => {
            let trials = [materials::trials(name.as_deref()), limits::trials(name.as_deref())].concat();
            if trials.is_empty() {
                return Err("there is no such material; see `etalon plugins`".into());
            }
            let effort = effort(samples, trials.len(), thorough);
            finish(judge("materials", trials, &effort, number, ledger)?, json)
        }
        Command::Sampling { name, samples, thorough, number, json, ledger } => {
            let trials = sampling::trials(name.as_deref());
            let effort = effort_of_sampling(samples, trials.len(), thorough);
            finish(judge("sampling", trials, &effort, number, ledger)?, json)
        }
        Command::Furnace { losses: Some(path), .. } => {
            std::fs::write(path, furnace::losses())?;
            Ok(Verdict::Equivalent)
        }
        Command::Furnace { name, samples, number, json, losses: None } => {
            let cells = furnace::cells(name.as_deref());
            let effort = Effort { albedo: 1e-3, ..effort(samples, cells.len(), true) };
            let mut outcomes = vec![];
            for cell in cells {
                outcomes.push(cell.run(&effort, number)?);
                outcomes.last().map(print);
            }
            finish(Report::new("furnace", outcomes), json)
        }
        Command::Ledger(arguments) => ledger::command::run(arguments),
        Command::Converge(arguments) => converge::run(arguments),
        Command::Table(arguments) => table::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Images(arguments) => images::command::run(arguments),
        Command::Report { output, from, quick } => {
            let effort = if quick { report::Effort::QUICK } else { report::Effort::USUAL };
            let verdict = report::write(&output, from.as_deref(), effort, |step| eprintln!("{step}"))?;
            say(format_args!("{verdict}: {}", output.display()));
            Ok(verdict)
        }
        Command::Stability { name, thorough, number, json, markdown } => {
            let effort = if thorough { stability::THOROUGH } else { 1 };
            let mut rows = vec![];
            for case in stability::cases() {
                if name.as_ref().is_none_or(|n| case.name.contains(n)) {
                    let row = case.check(effort, number);
                    say(format_args!("{:<13} {}: {}", row.verdict, row.case, row.found));
                    rows.push(row);
                }
            }
            if let Some(path) = markdown {
                let old = std::fs::read_to_string(&path).unwrap_or_default();
                std::fs::write(path, stability::updated(&old, &rows))?;
            }
            if let Some(path) = json {
                std::fs::write(path, to_json(&rows)?)?;
            }
            Ok(stability::verdict(&rows))
        }
        Command::Scenes { name, spp, margin, number, thorough, markdown, json } => {
            let mut outcomes = vec![];
            for reference in references::references(&references::folder())? {
                if name.as_ref().is_none_or(|n| reference.name.contains(n)) {
                    let outcome = reference.check(spp, margin, number)?;
                    print(&outcome);
                    outcomes.push(outcome);
                }
            }
            let chosen = |other: &str| name.as_ref().is_none_or(|n| other.contains(n));
            let effort = if thorough { 64 } else { 1 };
            let (mut table, mut related) = (vec![], vec![]);
            for case in closed_forms::cases().into_iter().filter(|c| chosen(&c.name)) {
                let outcome = case.check(effort, number)?;
                print(&outcome);
                outcomes.push(outcome.clone());
                table.push((case, outcome));
            }
            for relation in metamorphic::relations().into_iter().filter(|r| chosen(&r.name)) {
                let relation = if thorough { relation.thorough() } else { relation };
                let outcome = relation.check(1, number)?;
                print(&outcome);
                outcomes.push(outcome.clone());
                related.push(outcome);
            }
            if let Some(path) = markdown {
                std::fs::write(path, closed_forms::markdown(&table, &related))?;
            }
            finish(Report::new("scenes", outcomes), json)
        }
        Command::Museum(arguments) => Ok(museum::command::run(arguments)?),
    }
}

fn judge(
    title: &str,
    trials: Vec<Trial>,
    effort: &Effort,
    number: u64,
    ledger: Option<PathBuf>,
) -> Result<Report, Box<dyn Error>> {
    let mut outcomes = vec![];
    for trial in trials {
        if let Some(outcome) = trial.run(effort, number)? {
            print(&outcome);
            outcomes.push(outcome);
        }
    }
    if let Some(path) = ledger {
        validate::ledger::append(&path, &outcomes, number)?;
    }
    Ok(Report::new(title, outcomes))
}

fn finish(report: Report, json: Option<PathBuf>) -> Result<Verdict, Box<dyn Error>> {
    let count = |v: Verdict| report.outcomes.iter().filter(|o| o.verdict == v).count();
    let (equal, open, bad) =
        (count(Verdict::Equivalent), count(Verdict::Inconclusive), count(Verdict::Different));
    say(format_args!("{}: {equal} hold, {open} inconclusive, {bad} differ", report.verdict));
    if let Some(path) = json {
        std::fs::write(path, to_json(&Made::here(&report)?)? + "\n")?;
    }
    Ok(report.verdict)
}
