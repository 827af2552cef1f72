//! The command line of `validate stability`.

use super::{Row, THOROUGH, cases, updated, verdict};
use crate::console::{check_writable, say, write};
use crate::provenance::{Made, Provenance};
use serde::Serialize;
use std::error::Error;
use std::io::ErrorKind;
use std::path::PathBuf;
use validation::Verdict;
use validation::report::to_json;

#[derive(clap::Args)]
pub struct Arguments {
    /// Only cases whose name contains this
    name: Option<String>,
    /// Ten times the samples, and 10⁸ spawned rays
    #[arg(long)]
    thorough: bool,
    /// Another number, other seeds
    #[arg(long, default_value_t = 0, value_parser = crate::console::number)]
    number: u64,
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the table
    #[arg(long, value_name = "FILE", conflicts_with = "name")]
    markdown: Option<PathBuf>,
}

/// The document of `--json`, with its provenance.
#[derive(Serialize)]
struct Document<'a> {
    cases: &'a [Row],
}

/// Runs the cases; the verdict is equivalent if every case holds, or misses its expectation within its stated
/// limit.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn Error>> {
    let Arguments { name, thorough, number, json, markdown } = arguments;
    check_writable(&[], &[&markdown, &json])?;
    let effort = if thorough { THOROUGH } else { 1 };
    let mut rows = vec![];
    for case in cases() {
        if name.as_ref().is_none_or(|n| case.name.contains(n)) {
            let row = case.check(effort, number);
            say(format_args!("{:<13} {}: {}", row.verdict, row.case, row.found));
            rows.push(row);
        }
    }
    if rows.is_empty() {
        return Err("there is no such case".into());
    }
    if let Some(path) = markdown {
        let old = match std::fs::read_to_string(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            read => read.map_err(|e| format!("{}: {e}", path.display()))?,
        };
        etalon::files::write_file(&path, updated(&old, &Provenance::here(), &rows).as_bytes())?;
    }
    write(json.as_deref(), || Ok(to_json(&Made::here(&Document { cases: &rows }))?))?;
    Ok(verdict(&rows))
}
