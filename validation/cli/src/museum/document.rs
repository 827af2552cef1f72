//! The tables of `docs/museum.md`, made from the committed findings.

use super::findings::{Fate, Finding, Findings};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Replaces the text between the lines `<!-- NAME -->` and `<!-- end of NAME -->` of a document by `table`.
/// Error: the lines are missing.
pub fn insert(document: &str, name: &str, table: &str) -> Result<String, String> {
    let (begin, end) = (format!("<!-- {name} -->\n"), format!("<!-- end of {name} -->"));
    let missing = || format!("the document has no lines for the table `{name}`");
    let (before, rest) = document.split_once(&begin).ok_or_else(missing)?;
    let (_, after) = rest.split_once(&end).ok_or_else(missing)?;
    Ok(format!("{before}{begin}\n{table}\n{end}{after}"))
}

/// The table of all bugs, with their source and the test that detected each.
pub fn museum(findings: &Findings) -> String {
    let mut text = heading(findings, "bugs");
    text.push_str("| bug | what is wrong | who made it | noticed by |\n|---|---|---|---|\n");
    for bug in &findings.bugs {
        let Finding { name, about, source, fate, .. } = bug;
        writeln!(text, "| {name} | {} | {} | {} |", cell(about), linked(source), noticed(fate)).ok();
    }
    text
}

/// The share of mutants that were killed in each file, and the mutants that were not.
pub fn mutants(findings: &Findings) -> String {
    let mut text = heading(findings, "mutants");
    let mut files: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for bug in findings.bugs.iter().filter(|b| b.fate != Fate::DoesNotCompile) {
        let counts = files.entry(&bug.file).or_default();
        counts.0 += usize::from(bug.fate != Fate::Survived);
        counts.1 += 1;
    }
    text.push_str("| file | killed | of |\n|---|--:|--:|\n");
    for (file, (killed, all)) in files {
        writeln!(text, "| {file} | {killed} | {all} |").ok();
    }
    text.push_str("\n| survivor | change | why |\n|---|---|---|\n");
    for bug in findings.survivors() {
        writeln!(text, "| {} | {} | {} |", bug.name, cell(&bug.about), cell(&bug.source)).ok();
    }
    text
}

fn heading(findings: &Findings, what: &str) -> String {
    let (killed, all) = findings.killed();
    let share = 100.0 * killed as f64 / all.max(1) as f64;
    let commits: BTreeSet<&str> = findings.bugs.iter().map(|bug| bug.commit.as_str()).collect();
    let (s, commits) = (if commits.len() > 1 { "s" } else { "" }, Vec::from_iter(commits).join(", "));
    format!(
        "{killed} of {all} {what} killed, {share:.1} % ({}, commit{s} {commits}; {}).\n\n",
        findings.made.date, findings.made.machine
    )
}

fn noticed(fate: &Fate) -> String {
    match fate {
        Fate::Killed { program, test, .. } => format!("`{test}` ({program})"),
        Fate::Survived => "**nothing**".into(),
        Fate::DoesNotCompile => "the compiler".into(),
    }
}

/// A source as Markdown; one that ends in an address becomes a link.
fn linked(source: &str) -> String {
    match source.rsplit_once(' ') {
        Some((words, address)) if address.starts_with("https://") => format!("[{}]({address})", cell(words)),
        _ => cell(source),
    }
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_takes_the_place_of_the_last() {
        let document = "a\n<!-- t -->\nold\n<!-- end of t -->\nb";
        let once = insert(document, "t", "new").unwrap();
        assert_eq!(once, "a\n<!-- t -->\n\nnew\n<!-- end of t -->\nb");
        assert_eq!(insert(&once, "t", "new").unwrap(), once);
        assert!(insert(document, "u", "new").is_err());
    }

    #[test]
    fn addresses_become_links() {
        assert_eq!(linked("pbrt-v4 7 https://x.y/7"), "[pbrt-v4 7](https://x.y/7)");
        assert_eq!(linked("a | b"), "a \\| b");
    }
}
