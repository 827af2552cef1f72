//! `fuzz input`

use fuzz::inputs::formats::named;
use fuzz::inputs::seeds::{Seeds, folders};
use fuzz::inputs::watch::{Effort, Record, save, watch};
use fuzz::inputs::worker::{Meter, work};
use fuzz::inputs::{FORMATS, Format};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Duration;
use validate::console::{say, write};
use validation::report::to_json;

/// Counts the memory that inputs take.
#[global_allocator]
static ALLOCATOR: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

const METER: Meter = Meter {
    reset: || ALLOCATOR.reset_peak_usage(),
    current: || ALLOCATOR.current_usage(),
    peak: || ALLOCATOR.peak_usage(),
};

#[derive(clap::Args)]
pub struct Arguments {
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
}

impl Arguments {
    pub fn run(self) -> Result<bool, Box<dyn Error>> {
        let formats: Vec<&'static Format> = match &self.format {
            None => FORMATS.iter().collect(),
            Some(name) => vec![named(name).ok_or_else(|| {
                let known: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
                format!("no such format: {name}; known are {}", known.join(", "))
            })?],
        };
        std::fs::create_dir_all(&self.folder).map_err(|e| format!("{}: {e}", self.folder.display()))?;
        let effort = Effort { first: self.first, count: self.count, time: Duration::from_secs(self.seconds) };
        let mut records = vec![];
        for format in formats {
            let seeds = Seeds::read(format, &[folders(), self.seeds.clone()].concat())?;
            if self.worker {
                work(format, &seeds, effort, &self.folder, &METER);
                continue;
            }
            let record = self.watch(format, &seeds, effort)?;
            tell(&record);
            records.push(record);
        }
        write(self.json.as_deref(), || Ok(to_json(&records)?))?;
        Ok(records.iter().all(|record| record.findings.is_empty()))
    }

    /// Lets other processes read inputs of a format, and keeps those that break something.
    fn watch(&self, format: &'static Format, seeds: &Seeds, effort: Effort) -> Result<Record, String> {
        let program = std::env::current_exe().map_err(|e| e.to_string())?;
        let scratch = self.folder.join(format!("scratch-{}-{}", format.name, std::process::id()));
        let with_name = |e: std::io::Error| format!("{}: {e}", scratch.display());
        std::fs::create_dir_all(&scratch).map_err(with_name)?;
        let record = watch(format, seeds, effort, |first, count, time| {
            self.worker(&program, format, &scratch, Effort { first, count, time })
        })?;
        std::fs::remove_dir_all(&scratch).map_err(with_name)?;
        save(format, seeds, &record, &self.folder)?;
        Ok(record)
    }

    /// The command of a process that reads inputs.
    fn worker(
        &self,
        program: &Path,
        format: &Format,
        scratch: &Path,
        Effort { first, count, time }: Effort,
    ) -> std::process::Command {
        let mut command = std::process::Command::new(program);
        command.args(["input", format.name, "--worker", "--folder"]).arg(scratch);
        command.args(["--first", &first.to_string(), "--count", &count.to_string()]);
        command.args(["--seconds", &time.as_secs().max(1).to_string()]);
        self.seeds.iter().for_each(|other| {
            command.arg("--seeds").arg(other);
        });
        command
    }
}

fn tell(record: &Record) {
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
}
