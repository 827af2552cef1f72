//! Place and date of a report.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// Names and values of facts about the machine and the sources, for people.
pub fn here() -> Vec<(&'static str, String)> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let mut facts = vec![
        ("date", date(seconds / 86_400)),
        ("validate", env!("CARGO_PKG_VERSION").to_string()),
        ("processor", processor().unwrap_or_else(|| std::env::consts::ARCH.into())),
        ("cores", cores.to_string()),
        ("system", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)),
    ];
    if let Some(commit) = commit() {
        facts.insert(2, ("commit", commit));
    }
    facts
}

/// The commit and the processor in a few words, to be stored with measurements.
pub fn in_short() -> String {
    let wanted = |(name, value): (&str, String)| match name {
        "commit" | "processor" => Some(value),
        "cores" => Some(format!("{value} cores")),
        _ => None,
    };
    here().into_iter().filter_map(wanted).collect::<Vec<_>>().join(", ")
}

fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}

/// The commit of the checkout this was built from, if any; with a `+` if files differ from it.
fn commit() -> Option<String> {
    let git = |arguments: &[&str]| {
        let run =
            Command::new("git").args(["-C", env!("CARGO_MANIFEST_DIR")]).args(arguments).output().ok()?;
        run.status.success().then(|| String::from_utf8_lossy(&run.stdout).trim().to_string())
    };
    let changed = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(git(&["rev-parse", "--short", "HEAD"])? + if changed.is_empty() { "" } else { "+" })
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
