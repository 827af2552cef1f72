//! Date, machine and commit of a document of results.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::process::Command;
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

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

/// The commit where there is no git or no checkout.
pub const UNKNOWN: &str = "unknown";

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
    pub fn here(what: &'a T) -> Self {
        Self { made: Provenance::here(), what }
    }
}

impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}, commit {}, {}", self.date, self.commit, self.machine)
    }
}

impl Provenance {
    /// The provenance of this process, determined at the first call: sources may change during a long run of
    /// what was built from them. The commit is `unknown` without git or a checkout.
    pub fn here() -> Self {
        static HERE: OnceLock<Provenance> = OnceLock::new();
        HERE.get_or_init(Self::now).clone()
    }

    fn now() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let processor = processor().unwrap_or_else(|| "unknown processor".into());
        let commit = git(&["rev-parse", "--short", "HEAD"]).and_then(|commit| {
            let changed = git(&["status", "--porcelain", "--untracked-files=no", "--", "*.rs", "Cargo.*"])?;
            Some(commit + if changed.is_empty() { "" } else { "+" })
        });
        Self {
            date: today(),
            machine: format!("{cores} cores, {processor}"),
            commit: commit.unwrap_or_else(|| UNKNOWN.into()),
        }
    }
}

/// The name of the processor, if the system tells it.
pub fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}

/// Today's date in UTC, in the format of ISO 8601.
pub fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    date(seconds / 86_400)
}

/// The Gregorian date of a day since 1970-01-01, in the format of ISO 8601. Years begin in March here, so
/// that the leap day is the last.
fn date(days: u64) -> String {
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, turned) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", 400 * era + year + turned)
}

/// What git says in the checkout, if there are both.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).current_dir(crate::museum::root()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_have_dates() {
        let known = [(0, "1970-01-01"), (59, "1970-03-01"), (11_016, "2000-02-29"), (20_454, "2026-01-01")];
        for (days, expected) in known {
            assert_eq!(date(days), expected);
        }
    }
}
