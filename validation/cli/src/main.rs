//! The command line of the harness: one command for each kind of thing that can be judged.

use clap::Parser;
use etalon::command_line::given;
use std::error::Error;
use std::process::ExitCode;
use validate::{
    calibrate, console, converge, distributions, guest, images, intervals, ledger, museum, report, scenes,
    stability, table,
};
use validation::Verdict;

/// Judges materials, images and scenes.
///
/// Exit codes: 0 holds, 1 different, 2 bad input, 3 inconclusive.
#[derive(Parser)]
#[command(version)]
enum Command {
    /// All checks on all materials, or on one
    Bsdf(distributions::BsdfArguments),
    /// Error against run time of any renderers of renderers.toml
    Converge(converge::Arguments),
    /// Error against run time of every renderer on every scene of table.toml
    Table(table::Arguments),
    /// Whether comparisons of efficiency find what is there and nothing else
    Calibrate(calibrate::Arguments),
    /// All checks on all else that is drawn: light, lenses, filters, wavelengths, warps
    Sampling(distributions::SamplingArguments),
    /// Energy over roughness, index and angle
    Furnace(distributions::FurnaceArguments),
    /// Whether the p-values of a ledger are uniform, and its reseeded runs reject as often as their level
    /// says
    Ledger(ledger::command::Arguments),
    /// Whether two images have the same expectation
    Images(images::command::Arguments),
    /// How far each pixel of an image may be from what it expects
    Intervals(intervals::Arguments),
    /// All of it on one page: tables, plots and pictures
    Report(report::command::Arguments),
    /// Stiff and extreme scenes, each with a stated expectation
    Stability(stability::command::Arguments),
    /// Etalon against the stored references, closed forms and metamorphic relations
    Scenes(scenes::Arguments),
    /// Any renderer of renderers.toml against the stored references and closed forms
    Renderer(guest::Arguments),
    /// Whether the tests notice bugs, those of `validation/museum` or mutants
    Museum(museum::command::Arguments),
}

fn main() -> ExitCode {
    match run(given()).and_then(|verdict| Ok(console::all_said().map(|()| verdict)?)) {
        Ok(verdict) => ExitCode::from(verdict.exit_code()),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(command: Command) -> Result<Verdict, Box<dyn Error>> {
    match command {
        Command::Bsdf(arguments) => distributions::bsdf(arguments),
        Command::Converge(arguments) => converge::run(arguments),
        Command::Table(arguments) => table::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Sampling(arguments) => distributions::sampling(arguments),
        Command::Furnace(arguments) => distributions::furnace(arguments),
        Command::Ledger(arguments) => ledger::command::run(arguments),
        Command::Images(arguments) => images::command::run(arguments),
        Command::Intervals(arguments) => intervals::run(arguments),
        Command::Report(arguments) => report::command::run(arguments),
        Command::Stability(arguments) => stability::command::run(arguments),
        Command::Scenes(arguments) => scenes::run(arguments),
        Command::Renderer(arguments) => guest::run(arguments),
        Command::Museum(arguments) => Ok(museum::command::run(arguments)?),
    }
}
