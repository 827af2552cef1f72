//! When, where and from which sources a document of results was made.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::process::Command;
use std::sync::OnceLock;

/// What every committed document of results begins with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// As ISO 8601 writes it, in UTC.
    pub date: String,
    /// The kind of machine: cores and processor.
    pub machine: String,
    /// The commit of the checkout; `+` where files that are built differ from it.
    pub commit: String,
}

/// A document with its provenance before it.
#[derive(Serialize)]
pub struct Made<'a, T> {
    #[serde(flatten)]
    made: Provenance,
    #[serde(flatten)]
    what: &'a T,
}

impl<'a, T> Made<'a, T> {
    /// What was made here and today.
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
    /// Here and today, as it was when this was first asked: sources may change while a long run looks at what
    /// was built of them. Errors: there is no git, or no checkout.
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
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
