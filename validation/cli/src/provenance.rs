//! Date, machine and commit of a document of results.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::process::Command;
use std::sync::OnceLock;

/// The header of every committed document of results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Date in UTC, in the format of ISO 8601.
    pub date: String,
    /// Number of cores and kind of processor.
    pub machine: String,
    /// The commit of the checkout, with a `+` if source or Cargo files differ from it.
    pub commit: String,
}

/// A document preceded by its provenance.
#[derive(Serialize)]
pub struct Made<'a, T> {
    #[serde(flatten)]
    made: Provenance,
    #[serde(flatten)]
    what: &'a T,
}

impl<'a, T> Made<'a, T> {
    /// A document with the provenance of this process.
    pub fn here(what: &'a T) -> Result<Self, String> {
        Ok(Self { made: Provenance::here()?, what })
    }
}

impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}, commit {}, {}", self.date, self.commit, self.machine)
    }
}

impl Provenance {
    /// The provenance of this process, determined at the first call: sources may change during a long run of
    /// what was built from them. Errors: no git, or no checkout.
    pub fn here() -> Result<Self, String> {
        static HERE: OnceLock<Result<Provenance, String>> = OnceLock::new();
        HERE.get_or_init(Self::now).clone()
    }

    fn now() -> Result<Self, String> {
        let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
        let model = model.map_or("unknown processor", |(_, model)| model);
        let changed =
            told("git", &["status", "--porcelain", "--untracked-files=no", "--", "*.rs", "Cargo.*"])?;
        let commit = told("git", &["rev-parse", "--short", "HEAD"])?;
        Ok(Self {
            date: told("date", &["-u", "+%F"])?,
            machine: format!("{cores} cores, {model}"),
            commit: commit + if changed.is_empty() { "" } else { "+" },
        })
    }
}

fn told(program: &str, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(program).args(arguments).current_dir(crate::museum::root()).output();
    let output = output.map_err(|e| format!("{program}: {e}"))?;
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{program} {} failed: {}", arguments.join(" "), words.trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
