//! One file per command; each has arguments and a `run`.

mod explain;
mod merge;
mod plugins;
mod render;
mod replay;
mod size;
mod summary;
mod tax;
mod watch;

use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};
use clap::{CommandFactory, FromArgMatches, Parser};
use etalon::integrator::INTEGRATORS;
use etalon::integrator::links::LinkPolicy;
use etalon::integrator::path::reuse::{AUTO, PIXELS};
use etalon::sampler::SAMPLERS;
use etalon::scene::registry::Entry;
use etalon::scene::{self, Scene};
use etalon::spectrum::ColorMode;
use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
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
    /// The command of the command line; ends the program if there is none. A negative number is a value, which
    /// an option may refuse by its range, and not another option.
    pub fn given() -> Self {
        let command = Self::command().mut_subcommands(|subcommand| {
            subcommand.mut_args(|option| {
                match option.get_action().takes_values() && !option.is_positional() {
                    true => option.allow_negative_numbers(true),
                    false => option,
                }
            })
        });
        Self::from_arg_matches(&command.get_matches()).unwrap_or_else(|error| error.exit())
    }

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

/// Arguments that name a scene and override its settings.
#[derive(clap::Args)]
struct SceneArguments {
    /// Mitsuba 3 scene file
    scene: PathBuf,
    /// Value of a `$parameter` of the scene; may be repeated
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = definition)]
    define: Vec<(String, String)>,
    /// What a path carries
    #[arg(long, value_name = "spectral|rgb", default_value = "spectral")]
    color: ColorMode,
    /// Integrator to use instead of the scene's, with its default settings
    #[arg(long, value_name = "NAME", value_parser = integrator())]
    integrator: Option<String>,
    /// Edges of the longest path, instead of the scene's; -1 means no limit
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(i64).range(-1..=i64::from(u32::MAX)))]
    max_depth: Option<i64>,
    /// Light paths to a camera path, to find caustics; 0 leaves all to camera paths
    #[arg(long, value_name = "SHARE", value_parser = light_paths)]
    light_paths: Option<f64>,
    /// Neighbouring pixels that share what their paths find: a power of two up to 64, or `auto`, with which
    /// samples also count for all pixels that the filter reaches, and roulette begins earlier; less noise, but
    /// no longer independent
    #[arg(long, value_name = "PIXELS", value_parser = reuse)]
    reuse: Option<u32>,
    /// Light paths per group of sharing pixels, at most one per pixel; they find light that all of the group
    /// can use
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    shared_light_paths: Option<u32>,
    /// Where emitters are sampled through glass and by mirrors; `unaided`: where light paths cannot help;
    /// `guided`: there, along ways that these have shown
    #[arg(long, value_name = "WHERE", value_parser = LinkPolicy::ALL.map(|(name, _)| name))]
    links: Option<String>,
    /// Which of the scene's sensors, counted from 0, instead of the first
    #[arg(long, value_name = "N")]
    sensor: Option<usize>,
    /// Size of the film instead of the scene's, such as 640x480; all of it is rendered, whatever crop the
    /// scene has
    #[arg(long, value_name = "WxH", value_parser = size::parse_size)]
    size: Option<(u32, u32)>,
    /// Sampler to use instead of the scene's
    #[arg(long, value_name = "NAME", value_parser = one_of(SAMPLERS))]
    sampler: Option<String>,
    /// Another seed, another noise; 0 by default, or the scene's
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(..))]
    seed: Option<u32>,
}

/// Takes the name of an integrator that needs nothing to be said of it.
fn integrator() -> PossibleValuesParser {
    let alone = |name: &str| format!("<integrator type=\"{name}\"/>");
    let all = INTEGRATORS.iter().filter(|entry| entry.examples.contains(&alone(entry.name).as_str()));
    all.map(|entry| entry.name).collect::<Vec<_>>().into()
}

/// Takes the name of a model.
fn one_of<T>(models: &'static [Entry<T>]) -> PossibleValuesParser {
    models.iter().map(|model| model.name).collect::<Vec<_>>().into()
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

impl SceneArguments {
    /// Reads the scene by so many threads; 0 means one for each processor.
    fn load(&self, threads: usize) -> Result<Scene, Box<dyn Error>> {
        let overrides = scene::Overrides {
            integrator: self.integrator.clone(),
            max_depth: self.max_depth,
            sensor: self.sensor,
            size: self.size,
            seed: self.seed,
            sampler: self.sampler.clone(),
            light_paths: self.light_paths,
            reuse: self.reuse,
            shared_light_paths: self.shared_light_paths,
            links: self.links.clone(),
        };
        if let Some(twice) = self.repeated_definition() {
            return Err(format!("-D {twice} is given twice").into());
        }
        let load = || etalon::load(&self.scene, &self.define, self.color, &overrides);
        Ok(etalon::render::with_threads(threads, load)??)
    }

    /// A parameter of the scene that has two values.
    fn repeated_definition(&self) -> Option<&str> {
        let mut seen = BTreeSet::new();
        self.define.iter().map(|(name, _)| name.as_str()).find(|name| !seen.insert(*name))
    }

    /// Arguments of a command line that give the same scene.
    fn words(&self) -> Vec<String> {
        let mut words = vec![shown(&self.scene)];
        let mut say = |option: &str, value: Option<String>| {
            words.extend(value.into_iter().flat_map(|value| [option.to_owned(), value]));
        };
        self.define.iter().for_each(|(name, value)| say("-D", Some(format!("{name}={value}"))));
        say("--color", Some(self.color.name().to_owned()).filter(|_| self.color != ColorMode::Spectral));
        say("--integrator", self.integrator.clone());
        say("--max-depth", self.max_depth.map(|m| m.to_string()));
        say("--light-paths", self.light_paths.map(|share| share.to_string()));
        say(
            "--reuse",
            self.reuse.map(|pixels| if pixels == AUTO { "auto".into() } else { pixels.to_string() }),
        );
        say("--shared-light-paths", self.shared_light_paths.map(|count| count.to_string()));
        say("--links", self.links.clone());
        say("--sensor", self.sensor.map(|number| number.to_string()));
        say("--size", self.size.map(|(width, height)| format!("{width}x{height}")));
        say("--sampler", self.sampler.clone());
        say("--seed", self.seed.map(|seed| seed.to_string()));
        words
    }
}

/// A path as an argument: one that begins like an option is none where it begins with its folder.
fn shown(path: &Path) -> String {
    match path.display().to_string() {
        name if name.starts_with('-') => format!("./{name}"),
        name => name,
    }
}

/// Words, quoted for a shell.
fn quoted(words: &[String]) -> String {
    let plain =
        |word: &str| !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_./=,:".contains(c));
    let quote = |word: &String| {
        if plain(word) { word.clone() } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    words.iter().map(quote).collect::<Vec<_>>().join(" ")
}

fn definition(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    if name.is_empty() { Err("expected a name before `=`".into()) } else { Ok((name.into(), value.into())) }
}

fn light_paths(text: &str) -> Result<f64, String> {
    let range = etalon::integrator::path::RATIOS;
    let share = text.parse().ok().filter(|share| range.contains(share));
    share.ok_or_else(|| format!("expected a number from {} to {}", range.start(), range.end()))
}

fn reuse(text: &str) -> Result<u32, String> {
    if text == "auto" {
        return Ok(AUTO);
    }
    let pixels = text.parse().ok().filter(|pixels| PIXELS.contains(pixels));
    pixels.ok_or_else(|| "expected a power of two up to 64, or `auto`".into())
}
