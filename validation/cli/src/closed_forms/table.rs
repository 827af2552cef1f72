//! The tables of `docs/closed-forms.md`.

use super::ClosedForm;
use crate::metamorphic::{Alike, Relation};
use crate::provenance::Provenance;
use std::fmt::Write;
use validation::Outcome;

const TITLE: &str = "\
# Closed forms and relations

Written by `target/release/validate scenes --markdown docs/closed-forms.md`";

const CASES: &str = "\
## Scenes with an analytic answer

Every case is rendered twelve times, each with a seed of its own, and the 99 % interval (Student) of measured over
expected must lie within the margin; an interval that is too wide is inconclusive, which is no pass. Expected values are
computed in f64 by code that shares nothing with the renderer but the observer's tables, in
`validation/cli/src/closed_forms`. An interval of no width means that the estimator has no variance. `--thorough` takes
64 times the samples.

| case | formula and source | expected | measured − expected (99 % interval) | margin | verdict |
|---|---|--:|--:|--:|---|
";

const RELATIONS: &str = "
## Relations between renders

Both sides of a relation are rendered with seeds of their own and compared by the harness's comparison of images: the
99 % interval of the ratio of means must lie within the margin, and no tile may be beyond its noise; or, where the
margin is *bits*, every mean and variance must be equal to the bit. `--thorough` asks for a quarter of the margin.

| relation | finding | margin | verdict |
|---|---|--:|---|
";

/// A Markdown document with a row for each case and relation.
pub fn markdown(
    made: &Provenance,
    cases: &[(ClosedForm, Outcome)],
    relations: &[(Relation, Outcome)],
) -> String {
    let mut text = format!("{TITLE} ({made}).\n\n{CASES}");
    for (case, outcome) in cases {
        let figure = |name: &str| {
            let value = outcome.figures.get(name).copied().unwrap_or(f64::NAN);
            // A value that rounds to zero has no sign.
            let percent = format!("{:+.4}", 100.0 * (value - 1.0));
            if percent == "-0.0000" || percent == "+0.0000" { "0.0000".to_string() } else { percent }
        };
        let [deviation, low, high] = ["ratio", "ratio.low", "ratio.high"].map(figure);
        let (source, margin) = (case.source.replace('|', "\\|"), 100.0 * case.margin);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {source} | {} | {deviation} % ({low} to {high}) | {margin} % | {} |",
            case.name,
            digits(case.expected),
            outcome.verdict
        );
    }
    text.push_str(RELATIONS);
    for (relation, outcome) in relations {
        let ratio = ["ratio.G", "ratio.R"].iter().find_map(|name| outcome.figures.get(*name));
        let found = ratio.map_or(outcome.message.clone(), |ratio| format!("ratio of means {ratio:.5}"));
        let margin = match relation.alike {
            Alike::Bits => "bits".to_string(),
            Alike::Expectation(margin) | Alike::Mean(margin) => format!("{} %", 100.0 * margin),
        };
        let _ = writeln!(text, "| {} | {found} | {margin} | {} |", outcome.subject, outcome.verdict);
    }
    text
}

/// Six decimals, or six significant digits where fewer than three would remain.
fn digits(value: f64) -> String {
    if value.abs() < 1e-3 && value != 0.0 { format!("{value:.5e}") } else { format!("{value:.6}") }
}
