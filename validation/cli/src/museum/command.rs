//! `validate museum`.

use super::findings::{Findings, results};
use super::suite::Asked;
use super::{bugs, document, mutants, root};
use crate::console::{say, write};
use std::collections::BTreeSet;
use std::path::PathBuf;
use validation::Verdict;
use validation::report::to_json;

/// The committed findings on mutants.
const MUTANTS: &str = "validation/museum/mutants.json";
/// The document with the tables of findings.
const DOCUMENT: &str = "docs/museum.md";

/// Whether the tests notice bugs.
#[derive(clap::Args)]
pub struct Arguments {
    /// Only bugs whose names contain one of these
    names: Vec<String>,
    /// Instead of the catalogue, mutants of this file or folder
    #[arg(long, value_name = "PATH")]
    mutate: Vec<String>,
    /// How many mutants
    #[arg(long, default_value_t = 100)]
    sample: usize,
    /// Another number, other mutants
    #[arg(long, default_value_t = 0, value_parser = crate::console::number)]
    number: u64,
    /// Only tests that bear the name of the bug's file, chapter or folders; what these do not notice stays
    /// open
    #[arg(long)]
    near: bool,
    /// Only tests whose names contain this; what these do not notice stays open
    #[arg(long, value_name = "NAME", conflicts_with = "near")]
    test: Option<String>,
    /// Threads of a test program
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Where the sources are copied to and built
    #[arg(long, value_name = "FOLDER", default_value = "target/museum")]
    scratch: PathBuf,
    /// Write a JSON document after every bug; what it has on other bugs is kept
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Only bugs that the JSON document does not have yet
    #[arg(long, requires = "json")]
    resume: bool,
    /// Run nothing; put the tables of the committed findings into docs/museum.md
    #[arg(long)]
    document: bool,
}

/// Runs the command; the verdict is equivalent if all bugs are killed.
pub fn run(arguments: Arguments) -> Result<Verdict, String> {
    if arguments.document {
        return write_document();
    }
    let told = |e: std::io::Error| format!("{}: {e}", arguments.scratch.display());
    std::fs::create_dir_all(&arguments.scratch).map_err(told)?;
    let scratch = arguments.scratch.canonicalize().map_err(told)?;
    let sources = super::keep(&scratch)?;
    let changes = if arguments.mutate.is_empty() {
        let bugs = bugs::catalogue(&bugs::folder())?;
        bugs.iter().map(|bug| bug.change(&sources)).collect::<Result<Vec<_>, _>>()?
    } else {
        mutants::sample(&sources, &arguments.mutate, arguments.sample, arguments.number)?
    };
    let named = |name: &str| arguments.names.is_empty() || arguments.names.iter().any(|n| name.contains(n));
    if !changes.iter().any(|change| named(&change.name)) {
        return Err("there is no such bug".into());
    }
    // A run of some bugs keeps the findings on the others.
    let mut findings = Findings::here();
    if let Some(path) = arguments.json.as_deref().filter(|path| path.exists()) {
        findings.remember(Findings::read(path)?);
        findings.bugs.retain(|bug| changes.iter().any(|change| change.name == bug.name));
    }
    let known: BTreeSet<String> = findings.bugs.iter().map(|bug| bug.name.clone()).collect();
    let wanted = |name: &str| named(name) && !(arguments.resume && known.contains(name));
    let asked = match arguments.test {
        Some(name) => Asked::Named(name),
        None if arguments.near => Asked::Near,
        None => Asked::All,
    };
    let asked_for: Vec<String> =
        changes.iter().map(|change| change.name.clone()).filter(|name| named(name)).collect();
    super::examine(changes, wanted, &scratch, (arguments.jobs, &asked), |finding| {
        say(format_args!("{finding}"));
        findings.add(finding);
        write(arguments.json.as_deref(), || Ok(to_json(&findings)?)).map_err(|e| e.to_string())
    })?;
    let (killed, all) = findings.killed();
    // If only some tests were run and none of them detected the bug, there is no finding.
    let open = asked_for.iter().filter(|name| findings.bugs.iter().all(|bug| bug.name != **name)).count();
    say(format_args!("{killed} of {all} killed; {} do not compile; {open} open", findings.bugs.len() - all));
    Ok(match killed == all {
        false => Verdict::Different,
        true if open > 0 => Verdict::Inconclusive,
        true => Verdict::Equivalent,
    })
}

fn write_document() -> Result<Verdict, String> {
    let path = root().join(DOCUMENT);
    let told = |e: std::io::Error| format!("{}: {e}", path.display());
    let mut text = std::fs::read_to_string(&path).map_err(told)?;
    /// The name of the place in the document, the file of findings, and the function that makes a table of
    /// them.
    type Table = (&'static str, PathBuf, fn(&Findings) -> String);
    let tables: [Table; 2] =
        [("museum", results(), document::museum), ("mutants", root().join(MUTANTS), document::mutants)];
    for (name, file, table) in tables {
        let table = if file.exists() { table(&Findings::read(&file)?) } else { "Not yet run.\n".into() };
        text = document::insert(&text, name, &table)?;
    }
    write(Some(&path), || Ok(text)).map_err(|e| e.to_string())?;
    Ok(Verdict::Equivalent)
}
