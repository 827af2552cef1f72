//! The command line: `fuzz scenes`, `fuzz techniques`, `fuzz paths`, `fuzz input`.

use clap::Parser;
use etalon::files::write_file;
use fuzz::inputs::formats::named;
use fuzz::inputs::seeds::{Seeds, folders};
use fuzz::inputs::watch::{Effort, save, watch};
use fuzz::inputs::worker::{Meter, work};
use fuzz::inputs::{FORMATS, Format};
use fuzz::scenes::judge::{Answer, Failure, Judgement, judge};
use fuzz::scenes::mitsuba::Mitsuba;
use fuzz::scenes::{grammar, models::Models};
use fuzz::techniques::{Finding, judge as judge_techniques};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;
use validation::Verdict;

/// Counts the memory that inputs take.
#[global_allocator]
static ALLOCATOR: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

const METER: Meter = Meter {
    reset: || ALLOCATOR.reset_peak_usage(),
    current: || ALLOCATOR.current_usage(),
    peak: || ALLOCATOR.peak_usage(),
};

/// Random scenes and input files.
///
/// Exit codes: 0 nothing found, 1 found something, 2 could not run.
#[derive(Parser)]
#[command(version)]
enum Command {
    /// Random scenes by Etalon and by Mitsuba, which must be installed for python3
    Scenes {
        /// Numbers of the scenes
        #[arg(long, default_value = "0..500", value_delimiter = ',', value_parser = range)]
        numbers: Vec<std::ops::Range<u64>>,
        /// Samples of a pixel, at most
        #[arg(long, default_value_t = 1 << 14, value_parser = clap::value_parser!(u32).range(64..=1 << 24))]
        samples: u32,
        /// Where scenes that differ are left, and the record
        #[arg(long, default_value = "target/fuzzed-scenes")]
        folder: PathBuf,
    },
    /// Rooms of glass and mirrors, by every technique and by plain path tracing: equal but for noise
    Techniques {
        /// Numbers of the scenes
        #[arg(long, default_value = "0..100", value_delimiter = ',', value_parser = range)]
        numbers: Vec<std::ops::Range<u64>>,
        /// Samples of a pixel; what differs is confirmed with four times as many
        #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u64).range(64..=1 << 24))]
        samples: u64,
        /// Where scenes that differ are left, and the record
        #[arg(long, default_value = "target/fuzzed-techniques")]
        folder: PathBuf,
    },
    /// Paths through random scenes, by Etalon alone: 0 values that are not finite
    Paths {
        /// Number of paths, at least: scenes are followed whole
        #[arg(long, default_value_t = 100_000_000, value_parser = clap::value_parser!(u64).range(1..))]
        paths: u64,
        /// The first scene
        #[arg(long, default_value_t = 0)]
        first: u64,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Damaged files: no panic, no hang, no memory beyond a multiple of the input
    Input {
        /// xml, ply, obj, serialized, exr, picture, spd or peer; all unless given
        format: Option<String>,
        /// Seconds for each format
        #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..))]
        seconds: u64,
        /// Inputs of each format, at most
        #[arg(long, default_value_t = u64::MAX, hide_default_value = true)]
        count: u64,
        /// The first input
        #[arg(long, default_value_t = 0)]
        first: u64,
        /// Further folders of seeds; may be repeated
        #[arg(long, value_name = "DIR")]
        seeds: Vec<PathBuf>,
        /// Where inputs that break something are left
        #[arg(long, default_value = "target/fuzzed-inputs")]
        folder: PathBuf,
        /// Write a JSON document
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        /// Read inputs in this process, and say which
        #[arg(long, hide = true)]
        worker: bool,
    },
}

fn main() -> ExitCode {
    match run(Command::parse()) {
        Ok(clean) => ExitCode::from(u8::from(!clean)),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(command: Command) -> Result<bool, String> {
    match command {
        Command::Scenes { numbers, samples, folder } => scenes(numbers, samples, &folder),
        Command::Techniques { numbers, samples, folder } => techniques(numbers, samples, &folder),
        Command::Paths { paths, first, json } => follow(first, paths, json.as_deref()),
        Command::Input { format, seconds, count, first, seeds, folder, json, worker } => {
            let formats: Vec<&Format> = match &format {
                None => FORMATS.iter().collect(),
                Some(name) => vec![named(name).ok_or_else(|| {
                    let known: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
                    format!("no such format: {name}; known are {}", known.join(", "))
                })?],
            };
            let time = Duration::from_secs(seconds);
            let seeds = [folders(), seeds].concat();
            std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            inputs(&formats, &seeds, Effort { first, count, time }, &folder, json.as_deref(), worker)
        }
    }
}

fn inputs(
    formats: &[&'static Format],
    folders: &[PathBuf],
    effort: Effort,
    folder: &Path,
    json: Option<&Path>,
    worker: bool,
) -> Result<bool, String> {
    let mut records = vec![];
    for format in formats.iter().copied() {
        let seeds = Seeds::read(format, folders)?;
        if worker {
            work(format, &seeds, effort.first, effort.count, effort.time, folder, &METER);
            continue;
        }
        let program = std::env::current_exe().map_err(|e| e.to_string())?;
        let scratch = folder.join(format!("scratch-{}-{}", format.name, std::process::id()));
        std::fs::create_dir_all(&scratch).map_err(|e| format!("{}: {e}", scratch.display()))?;
        let start = |first: u64, count: u64, time: Duration| {
            let mut command = std::process::Command::new(&program);
            command.args(["input", format.name, "--worker", "--folder"]).arg(&scratch);
            command.args(["--first", &first.to_string(), "--count", &count.to_string()]);
            command.args(["--seconds", &time.as_secs().max(1).to_string()]);
            folders.iter().skip(fuzz::inputs::seeds::folders().len()).for_each(|other| {
                command.arg("--seeds").arg(other);
            });
            command
        };
        let record = watch(format, &seeds, effort, start)?;
        std::fs::remove_dir_all(&scratch).map_err(|e| e.to_string())?;
        save(format, &seeds, &record, folder)?;
        say(format_args!(
            "{}: {} inputs of {} seeds in {:.0} s, {} findings; at most {:.1} % of the memory allowed and {:.2} s an input",
            record.format,
            record.inputs,
            record.seeds,
            record.seconds,
            record.findings.len(),
            100.0 * record.most_memory,
            record.slowest_seconds
        ));
        record.findings.iter().for_each(|f| say(format_args!("  input {}: {}", f.input, f.what)));
        records.push(record);
    }
    write(json, &records)?;
    Ok(records.iter().all(|r| r.findings.is_empty()))
}

/// Prints a line. A closed pipe, as behind `head`, is no reason to stop: documents are still written.
fn say(line: std::fmt::Arguments) {
    writeln!(std::io::stdout(), "{line}").ok();
}

/// Writes a document if a path is given: completely, or not at all.
fn write(json: Option<&Path>, document: &impl serde::Serialize) -> Result<(), String> {
    let Some(path) = json else { return Ok(()) };
    let text = serde_json::to_string_pretty(document).map_err(|e| e.to_string())?;
    write_file(path, (text + "\n").as_bytes()).map_err(|e| e.to_string())
}

fn follow(first: u64, paths: u64, json: Option<&Path>) -> Result<bool, String> {
    // Written after every scene, so that results survive an interrupted run.
    let mut written = Ok(());
    let told = |record: &fuzz::paths::Record| written = write(json, record);
    let record = fuzz::paths::follow(&Models::read()?, &files().to_string_lossy(), first, paths, told);
    let record = record?;
    written?;
    let fuzz::paths::Record { scenes, refused, paths, cut, not_finite, negative, first } = &record;
    say(format_args!(
        "{paths} paths in {scenes} scenes, {refused} more refused; {cut} cut, {not_finite} not finite, {negative} pixels negative"
    ));
    first.iter().for_each(|fault| say(format_args!("  {fault}")));
    Ok(first.is_empty())
}

/// A file of lines about scenes, to which a run adds its own.
struct Record {
    path: PathBuf,
    file: std::fs::File,
}

impl Record {
    fn within(folder: &Path) -> Result<Self, String> {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let path = folder.join("record.jsonl");
        let file = std::fs::OpenOptions::new().create(true).append(true).open(&path);
        file.map_err(|e| format!("{}: {e}", path.display())).map(|file| Self { path, file })
    }

    fn add(&mut self, line: &impl serde::Serialize) -> Result<(), String> {
        let line = serde_json::to_string(line).map_err(|e| e.to_string())?;
        writeln!(self.file, "{line}").map_err(|e| format!("{}: {e}", self.path.display()))
    }
}

/// Where the files of random scenes are.
fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../references/scenes")
}

fn techniques(numbers: Vec<std::ops::Range<u64>>, samples: u64, folder: &Path) -> Result<bool, String> {
    let mut record = Record::within(folder)?;
    let models = Models::read()?;
    let mut counts: BTreeMap<(&str, Verdict), u32> = BTreeMap::new();
    let mut clean = true;
    for number in numbers.into_iter().flatten() {
        for found in judge_techniques(&models, &files().to_string_lossy(), number, samples)? {
            let Finding { technique, verdict, message, text, .. } = &found;
            *counts.entry((technique, *verdict)).or_default() += 1;
            if *verdict == Verdict::Different {
                clean = false;
                let name = folder.join(format!("{number} {technique}.xml"));
                write_file(&name, text.as_bytes()).map_err(|e| e.to_string())?;
                say(format_args!("{number}, {technique}: {message}"));
            }
            record.add(&found)?;
        }
    }
    if counts.is_empty() {
        return Err("there is no number in that range".into());
    }
    for ((technique, verdict), count) in counts {
        say(format_args!("{technique}: {count} {verdict:?}"));
    }
    Ok(clean)
}

fn scenes(numbers: Vec<std::ops::Range<u64>>, samples: u32, folder: &Path) -> Result<bool, String> {
    let mut record = Record::within(folder)?;
    let (models, files) = (Models::read()?, files());
    let mut mitsuba = Mitsuba::start()?;
    let mut counts: BTreeMap<Answer, u32> = BTreeMap::new();
    for number in numbers.into_iter().flatten() {
        let scene =
            grammar::scene(&models, &files.to_string_lossy(), number).ok_or("the grammar has a dead end")?;
        let found: Judgement = match judge(&scene, number, folder, &mut mitsuba, samples) {
            Ok(found) => found,
            Err(Failure::Mitsuba(words)) => {
                mitsuba = Mitsuba::start()?;
                Judgement::died(&scene, number, words)
            }
            Err(Failure::Own(words)) => return Err(words),
        };
        if found.answer != Answer::RefusedByBoth {
            let Judgement { answer, samples, message, .. } = &found;
            say(format_args!("{number}: {answer:?} with {samples} samples: {message}"));
        }
        *counts.entry(found.answer).or_default() += 1;
        record.add(&found)?;
    }
    if counts.is_empty() {
        return Err("there is no number in that range".into());
    }
    let counts_said: Vec<String> =
        counts.iter().map(|(answer, count)| format!("{count} {answer:?}")).collect();
    say(format_args!("{}", counts_said.join(", ")));
    Ok(counts.keys().all(|answer| answer.is_clean()))
}

fn range(text: &str) -> Result<std::ops::Range<u64>, String> {
    let number = |text: &str| text.parse::<u64>().map_err(|_| "expected such as 0..500 or 7".to_string());
    let Some((from, to)) = text.split_once("..") else { return number(text).map(|n| n..n + 1) };
    Ok(number(from)?..number(to)?)
}
