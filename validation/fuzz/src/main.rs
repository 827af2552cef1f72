//! The command line: `fuzz scenes`, `fuzz techniques`, `fuzz paths`, `fuzz input`.

mod command;

use clap::Parser;
use etalon::command_line::given;
use std::error::Error;
use std::process::ExitCode;
use validate::console::all_said;

/// Random scenes and input files.
///
/// Exit codes: 0 nothing found, 1 found something, 2 could not run.
#[derive(Parser)]
#[command(version)]
enum Command {
    /// Random scenes by Etalon and by Mitsuba, which must be installed for python3
    Scenes(command::scenes::Arguments),
    /// Rooms of glass and mirrors, by every technique and by plain path tracing: equal but for noise
    Techniques(command::techniques::Arguments),
    /// Paths through random scenes, by Etalon alone: 0 values that are not finite
    Paths(command::paths::Arguments),
    /// Damaged files: no panic, no hang, no memory beyond a multiple of the input
    Input(command::input::Arguments),
}

fn main() -> ExitCode {
    match run(given()).and_then(|clean| Ok(all_said().map(|()| clean)?)) {
        Ok(clean) => ExitCode::from(u8::from(!clean)),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Whether nothing was found.
fn run(command: Command) -> Result<bool, Box<dyn Error>> {
    match command {
        Command::Scenes(arguments) => arguments.run(),
        Command::Techniques(arguments) => arguments.run(),
        Command::Paths(arguments) => arguments.run(),
        Command::Input(arguments) => arguments.run(),
    }
}
