//! The fates of the bugs, and their JSON document.

use super::plant::Change;
use crate::files;
use crate::provenance::Provenance;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};

/// The committed findings on the catalogue.
pub fn results() -> PathBuf {
    super::root().join("validation/museum/results.json")
}

/// The fate of a bug.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// A test failed, after this number of seconds on the machine under its load.
    Killed { program: String, test: String, seconds: f64 },
    /// No test failed.
    Survived,
    /// The compiler rejected the bug, which says nothing about the tests.
    DoesNotCompile,
}

/// A bug and its fate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    pub name: String,
    pub about: String,
    pub source: String,
    pub file: String,
    /// The commit of the sources in which the bug was planted.
    #[serde(default)]
    pub commit: String,
    pub fate: Fate,
}

/// A run of the museum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    #[serde(flatten)]
    pub made: Provenance,
    pub bugs: Vec<Finding>,
}

impl Finding {
    pub fn new(change: &Change, fate: Fate) -> Self {
        let Change { name, about, source, file, .. } = change.clone();
        Self { name, about, source, file, commit: String::new(), fate }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.fate {
            Fate::Killed { program, test, seconds } => {
                write!(f, "killed    {}: {test} of {program} after {seconds:.0} s", self.name)
            }
            Fate::Survived => write!(f, "SURVIVED  {} ({}): {}", self.name, self.file, self.about),
            Fate::DoesNotCompile => write!(f, "no code   {} ({}): {}", self.name, self.file, self.about),
        }
    }
}

impl Findings {
    /// Empty findings with the provenance of this run.
    pub fn here() -> Self {
        Self { made: Provenance::here(), bugs: vec![] }
    }

    /// Reads the findings of a document. Errors: no such file, or other content.
    pub fn read(path: &Path) -> Result<Self, String> {
        files::json(path)
    }

    /// Adds a finding with this run's commit, replacing an earlier one on the same bug.
    pub fn add(&mut self, finding: Finding) {
        let finding = Finding { commit: self.made.commit.clone(), ..finding };
        match self.bugs.iter_mut().find(|known| known.name == finding.name) {
            Some(known) => *known = finding,
            None => self.bugs.push(finding),
        }
    }

    /// Takes over earlier findings, each with the commit it belongs to.
    pub fn remember(&mut self, earlier: Findings) {
        for mut finding in earlier.bugs {
            if finding.commit.is_empty() {
                finding.commit.clone_from(&earlier.made.commit);
            }
            self.bugs.push(finding);
        }
    }

    /// The number of bugs that were killed, and of those that compile.
    pub fn killed(&self) -> (usize, usize) {
        let killed = self.bugs.iter().filter(|b| matches!(b.fate, Fate::Killed { .. })).count();
        (killed, killed + self.survivors().count())
    }

    pub fn survivors(&self) -> impl Iterator<Item = &Finding> {
        self.bugs.iter().filter(|b| b.fate == Fate::Survived)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earlier_findings_keep_their_commit() {
        let text = r#"{"date": "2026-01-01", "machine": "m", "commit": "abc", "bugs": [
            {"name": "a", "about": "b", "source": "c", "file": "d",
             "fate": {"killed": {"program": "p", "test": "t", "seconds": 1.0}}},
            {"name": "e", "about": "f", "source": "g", "file": "h", "commit": "older", "fate": "survived"}]}"#;
        let earlier: Findings = serde_json::from_str(text).unwrap();
        let mut findings = Findings { made: earlier.made.clone(), bugs: vec![] };
        findings.made.commit = "now".into();
        findings.remember(earlier);
        assert_eq!(findings.killed(), (1, 2));
        let again = Finding { fate: Fate::Survived, ..findings.bugs[0].clone() };
        findings.add(again);
        let commits: Vec<&str> = findings.bugs.iter().map(|bug| bug.commit.as_str()).collect();
        assert_eq!(commits, ["now", "older"]);
        assert_eq!(findings.killed(), (0, 2));
    }
}
