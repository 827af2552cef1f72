//! The bug museum: would the suite notice?
//!
//! A bug is an expression of the source that is replaced by a wrong one, as `validation/museum/bugs` says, or
//! as [`mutants`] makes them up. The sources are copied to a scratch folder, and each expression becomes a
//! choice there: `if on(7) { wrong } else { right }`. So one build holds all bugs, an environment variable
//! lets one of them out, and the code that is released knows nothing of them. [`suite`] then runs every test
//! program until one fails.

pub mod bugs;
pub mod cargo;
pub mod command;
pub mod document;
pub mod findings;
pub mod mutants;
pub mod plant;
pub mod suite;

use cargo::{Compiled, Program};
use findings::{Fate, Finding};
use plant::Change;
use std::path::{Path, PathBuf};
use suite::{Asked, Suite};

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Copies the sources to `scratch`, so that a run sees one state of them however long it takes; the folder of
/// the copy.
pub fn keep(scratch: &Path) -> Result<PathBuf, String> {
    let sources = scratch.join("sources");
    plant::copy(&root(), &plant::known_to_git(&root())?, &sources)?;
    Ok(sources)
}

/// Plants all changes, which were found in what [`keep`] has kept in `scratch`, and lets out those that are
/// `wanted`, one after another; `tell` hears of every finding.
///
/// `scratch` is kept between runs, so that a second one compiles only what has changed. Errors are a tree
/// that cannot be copied or built, and a test that fails without any bug.
pub fn examine(
    changes: Vec<Change>,
    wanted: impl Fn(&str) -> bool,
    scratch: &Path,
    (jobs, asked): (usize, &Asked),
    mut tell: impl FnMut(Finding) -> Result<(), String>,
) -> Result<(), String> {
    let mut rest = changes;
    while !rest.is_empty() {
        let (together, later) = plant::apart(rest);
        rest = later;
        if !together.iter().any(|change| wanted(&change.name)) {
            continue;
        }
        let Build { planted, refused, programs } = build(together, scratch)?;
        refused.iter().try_for_each(|change| tell(Finding::new(change, Fate::DoesNotCompile)))?;
        let mut suite = Suite::new(programs, jobs);
        for (index, change) in planted.iter().enumerate().filter(|(_, change)| wanted(&change.name)) {
            let fate = suite.judge(index + 1, change, asked)?;
            fate.map_or(Ok(()), |fate| tell(Finding::new(change, fate)))?;
        }
    }
    Ok(())
}

/// A tree with bugs in it.
struct Build {
    planted: Vec<Change>,
    /// What the compiler does not take.
    refused: Vec<Change>,
    programs: Vec<Program>,
}

/// Builds the tree with all changes but those that the compiler refuses.
fn build(mut changes: Vec<Change>, scratch: &Path) -> Result<Build, String> {
    let mut refused = vec![];
    loop {
        let places = plant::plant(&scratch.join("sources"), &scratch.join("tree"), &changes)?;
        let bad = match cargo::compile(scratch, &places)? {
            Compiled::Programs(programs) => {
                return Ok(Build { planted: changes, refused, programs });
            }
            Compiled::Refused(bad) => bad,
        };
        let (wrong, right) = changes.into_iter().enumerate().partition::<Vec<_>, _>(|(i, _)| bad.contains(i));
        refused.extend(wrong.into_iter().map(|(_, change)| change));
        changes = right.into_iter().map(|(_, change)| change).collect();
    }
}
