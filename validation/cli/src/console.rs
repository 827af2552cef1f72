//! Output to the terminal and to files, and numbers from the command line.

use crate::provenance::Provenance;
use std::error::Error;
use std::fmt::Arguments;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;
use validation::Outcome;

/// The first error of standard output that was more than a closed pipe.
static LOST: OnceLock<String> = OnceLock::new();

/// Prints a line on standard output. A closed pipe, as behind `head`, is no reason to stop: documents are
/// still written, and the exit code is still valid. What else is lost is an error at the end: [`all_said`].
pub fn say(line: Arguments) {
    match writeln!(std::io::stdout(), "{line}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            LOST.get_or_init(|| error.to_string());
        }
        _ => {}
    }
}

/// Error: some of what was to be printed was lost, as on a full disk.
pub fn all_said() -> Result<(), String> {
    LOST.get().map_or(Ok(()), |error| Err(format!("standard output: {error}")))
}

/// Prints an outcome as a line.
pub fn print(outcome: &Outcome) {
    say(format_args!("{:<13} {}: {}", outcome.verdict.to_string(), outcome.subject, outcome.message));
}

/// Writes a document to a file if a path is given: completely, or not at all.
pub fn write(
    path: Option<&Path>,
    text: impl FnOnce() -> Result<String, Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let Some(path) = path else { return Ok(()) };
    let mut text = text()?;
    if !text.ends_with('\n') {
        text.push('\n');
    }
    Ok(etalon::files::write_file(path, text.as_bytes())?)
}

/// Tests in advance whether documents can be written to the given paths, each of its own and none that of a
/// file that is read, and determines their provenance.
pub fn check_writable(read: &[&Path], written: &[&Option<PathBuf>]) -> Result<(), Box<dyn Error>> {
    let read: Vec<PathBuf> = read.iter().map(|path| path.to_path_buf()).collect();
    let written: Vec<Option<&PathBuf>> = written.iter().map(|path| path.as_ref()).collect();
    etalon::files::check_outputs(&read, &written)?;
    if written.iter().any(Option::is_some) {
        // The commit is that of the beginning.
        Provenance::here();
    }
    Ok(())
}

/// Tests that everything asked for by name exists: a misspelt name would otherwise be left out in silence.
pub fn all_known<'a>(
    what: &str,
    asked: &[String],
    known: impl Iterator<Item = &'a str>,
) -> Result<(), String> {
    let known: Vec<&str> = known.collect();
    match asked.iter().find(|name| !known.contains(&name.as_str())) {
        Some(name) => Err(format!("there is no {what} {name:?}, expected one of {}", known.join(", "))),
        None => Ok(()),
    }
}

/// Parses the number of a run, from which seeds follow. Error: one that leaves no room for those of its parts.
pub fn number(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|n| *n < 1 << 32);
    number.ok_or_else(|| "expected a number below 2³²".into())
}

/// Parses a number of samples. Error: so few that neither a mean nor its error means anything.
pub fn samples(text: &str) -> Result<usize, String> {
    const FEWEST: usize = 64;
    let number = text.parse().ok().filter(|n| *n >= FEWEST);
    number.ok_or_else(|| format!("expected a number of at least {FEWEST}"))
}

/// Parses a share written with a per cent sign. Error: any other text.
pub fn percentage(text: &str) -> Result<f64, String> {
    let number = text.trim().strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    number
        .filter(|v| *v > 0.0 && v.is_finite())
        .map(|v| v / 100.0)
        .ok_or_else(|| "expected such as 0.25%".into())
}

/// Parses a time limit in seconds. Error: one that is not positive, or too long to be told.
pub fn positive_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| *s > 0.0);
    let limit = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    limit.ok_or_else(|| "expected a positive number of seconds".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentage_has_its_sign() {
        assert_eq!([" 0.25% ", "50 %"].map(percentage), [Ok(0.0025), Ok(0.5)]);
        let refused = ["0.005", "1%%", "%", "-1%", "NaN%", "inf%", ""];
        assert!(refused.into_iter().all(|text| percentage(text).is_err()));
    }

    #[test]
    fn a_time_limit_is_a_positive_number() {
        assert_eq!(positive_seconds("0.5"), Ok(Duration::from_millis(500)));
        let refused = ["0", "-1", "NaN", "inf", "1e300", "a minute", ""];
        assert!(refused.into_iter().all(|text| positive_seconds(text).is_err()));
    }

    #[test]
    fn a_misspelt_name_is_refused() {
        let asked = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
            all_known("scene", &names, ["pane", "bulb"].into_iter())
        };
        assert_eq!(asked(&["bulb"]), Ok(()));
        let error = asked(&["bulb", "pnae"]).unwrap_err();
        assert_eq!(error, "there is no scene \"pnae\", expected one of pane, bulb");
    }

    #[test]
    fn no_document_takes_the_place_of_another_or_of_what_is_read() {
        let (a, b) = (Some(PathBuf::from("a.json")), Some(PathBuf::from("./b.json")));
        let refused = |read: &[&Path], written: &[&Option<PathBuf>]| check_writable(read, written).is_err();
        assert!(!refused(&[Path::new("c.exr")], &[&a, &None, &b]));
        assert!(refused(&[], &[&a, &b, &a]) && refused(&[Path::new("b.json")], &[&a, &b]));
    }

    #[test]
    fn a_document_that_cannot_be_written_leaves_the_old_one() {
        let folder = std::env::temp_dir().join(format!("etalon-console-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.json");
        let written = || write(Some(&path), || Ok("new".into())).map_err(|error| error.to_string());
        assert_eq!(written(), Ok(()));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new\n");
        std::fs::write(&path, "old").unwrap();
        // A folder where the partial file would be written.
        std::fs::create_dir(folder.join("a.json.partial")).unwrap();
        assert!(written().is_err_and(|error| error.contains("a.json: cannot write")));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
