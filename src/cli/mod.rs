//! One file per command; each has arguments and a `run`.

mod explain;
mod merge;
mod plugins;
mod render;
mod replay;
mod scene_arguments;
mod size;
mod summary;
mod tax;
mod watch;
mod words;

use clap::Parser;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Exit code for input or usage that cannot be used.
pub const BAD_INPUT: u8 = 2;

/// Exit code of an image that is written, but has samples that are not finite.
const NOT_FINITE: u8 = 1;

/// Exit code for an error that was asked for and is not attained.
const UNATTAINED: u8 = 3;

/// Exit code after Ctrl-C, as shells have it: 128 and the number of the signal.
const INTERRUPTED: u8 = 130;

/// Prints a line to standard output; an error, such as a full disk, is returned from the function.
macro_rules! say {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        writeln!(std::io::stdout(), $($words)*).map_err(|error| std::io::Error::other(format!("standard output: {error}")))?
    }};
}
use say;

type Outcome = Result<ExitCode, Box<dyn Error>>;

/// A spectral path tracer that is its own measuring stick.
///
/// Exit codes: 0 done; 1 done, but samples were not finite; 2 bad input or usage; 3 done, but the error that
/// was asked for is not attained; 130 interrupted.
#[derive(Parser)]
#[command(version = etalon::VERSION)]
pub enum Command {
    Render(render::Arguments),
    Merge(merge::Arguments),
    Explain(explain::Arguments),
    Replay(replay::Arguments),
    Plugins(plugins::Arguments),
}

impl Command {
    pub fn run(self) -> Outcome {
        match self {
            Self::Render(arguments) => arguments.run(),
            Self::Merge(arguments) => arguments.run(),
            Self::Explain(arguments) => arguments.run(),
            Self::Replay(arguments) => arguments.run(),
            Self::Plugins(arguments) => arguments.run(),
        }
    }
}

/// Takes the name of an OpenEXR file, unless it is that of a file of another kind.
fn exr_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| of_kind(path, "exr", "OpenEXR"))
}

/// Takes the name of a PNG file, unless it is that of a file of another kind.
fn png_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| of_kind(path, "png", "PNG"))
}

fn of_kind(path: PathBuf, ending: &str, kind: &str) -> Result<PathBuf, String> {
    const ENDINGS: [&str; 6] = ["exr", "png", "jpg", "jpeg", "hdr", "xml"];
    if path.as_os_str() == "-" {
        return Err(format!(
            "it is replaced when complete, which standard output cannot be: expected a file.{ending}"
        ));
    }
    let found = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match found.filter(|found| found != ending && ENDINGS.contains(&found.as_str())) {
        None => Ok(path),
        Some(other) => {
            let expected = path.with_extension(ending).display().to_string();
            Err(format!("the file is {kind}, not .{other}: expected such as {expected}"))
        }
    }
}

/// Checks that a text is HOST:PORT.
fn address(text: &str) -> Result<String, String> {
    let port =
        text.rsplit_once(':').filter(|(host, _)| !host.is_empty()).map(|(_, port)| port.parse::<u16>());
    if matches!(port, Some(Ok(_))) { Ok(text.into()) } else { Err("expected such as localhost:14158".into()) }
}
