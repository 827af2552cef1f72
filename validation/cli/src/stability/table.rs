//! The table of `docs/stability.md`.

use super::{Row, Standing};
use crate::provenance::Provenance;
use std::fmt::Write;

const TITLE: &str = "\
# Stiff and extreme scenes

Written by `target/release/validate stability --markdown docs/stability.md`";

const ABOUT: &str = "\
The cases are in `validation/cli/src/stability`. Every row states what is expected, what was found and whether it holds.
A closed form holds if the 99 % interval of twelve renders over the formula lies within the margin. *The same numbers*
means that both scenes are rendered with the same random numbers, so that the mean difference of pixels is rounding and
the paths it sends elsewhere. A *limit* is an expectation that is missed for a known reason by no more than a stated
amount: a farther miss differs.

";

/// The part of the document after this line is kept when the table is written again.
const BY_HAND: &str = "<!-- What follows is written by hand. -->";

/// The document with an updated table.
pub fn updated(document: &str, made: &Provenance, rows: &[Row]) -> String {
    let kept = document.split_once(BY_HAND).map(|(_, kept)| format!("\n{BY_HAND}{kept}"));
    markdown(made, rows) + &kept.unwrap_or_default()
}

/// The table as Markdown, with a row for each case.
fn markdown(made: &Provenance, rows: &[Row]) -> String {
    let count = |verdict: Standing| rows.iter().filter(|row| row.verdict == verdict).count();
    let mut text = format!(
        "{TITLE} ({made}).\n\n{ABOUT}{} cases: {} hold, {} are known limits, {} are inconclusive, {} differ.\n\n\
         | case | expectation | found | margin | verdict |\n|---|---|---|--:|---|\n",
        rows.len(),
        count(Standing::Holds),
        count(Standing::Limit),
        count(Standing::Inconclusive),
        count(Standing::Differs)
    );
    for row in rows {
        let cell = |text: &str| text.replace('|', "\\|");
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} |",
            row.case,
            cell(&row.expectation),
            cell(&row.found),
            shown(row.margin),
            row.verdict
        );
    }
    if count(Standing::Limit) > 0 {
        text.push_str("\n## Known limits\n\n");
        for row in rows {
            if let Some(why) = row.limit {
                let _ = writeln!(text, "- {} ({}): {why}", row.case, row.found);
            }
        }
    }
    text
}

fn shown(margin: f64) -> String {
    if margin == 0.0 { "bits".into() } else { format!("{margin:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_by_hand_survives() {
        let document = format!("old table\n{BY_HAND}\n\n## More\n");
        let made = Provenance::here();
        let new = updated(&document, &made, &[]);
        assert!(new.starts_with("# Stiff") && new.ends_with("\n\n## More\n") && !new.contains("old table"));
        assert_eq!(updated(&new, &made, &[]), new);
    }
}
