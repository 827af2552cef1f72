//! What was measured, as `docs/closed-forms.md` shows it.

use super::ClosedForm;
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
99 % interval of the ratio of means must lie within 1 %, and no tile may be beyond its noise; or, where it says so,
every mean and variance must be equal to the bit. `--thorough` asks for 0.25 %.

| relation | finding | verdict |
|---|---|---|
";

/// A Markdown document, a case or relation a row.
pub fn markdown(made: &Provenance, cases: &[(ClosedForm, Outcome)], relations: &[Outcome]) -> String {
    let mut text = format!("{TITLE} ({made}).\n\n{CASES}");
    for (case, outcome) in cases {
        let figure = |name: &str| {
            let value = outcome.figures.get(name).copied().unwrap_or(f64::NAN);
            // Neither sign is meant of what rounds to nothing.
            let percent = format!("{:+.4}", 100.0 * (value - 1.0));
            if percent == "-0.0000" || percent == "+0.0000" { "0.0000".to_string() } else { percent }
        };
        let [deviation, low, high] = ["ratio", "ratio.low", "ratio.high"].map(figure);
        let (source, margin) = (case.source.replace('|', "\\|"), 100.0 * case.margin);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {source} | {:.6} | {deviation} % ({low} to {high}) | {margin} % | {} |",
            case.name, case.expected, outcome.verdict
        );
    }
    text.push_str(RELATIONS);
    for outcome in relations {
        let ratio = ["ratio.G", "ratio.R"].iter().find_map(|name| outcome.figures.get(*name));
        let found = ratio.map_or(outcome.message.clone(), |ratio| format!("ratio of means {ratio:.5}"));
        let _ = writeln!(text, "| {} | {found} | {} |", outcome.subject, outcome.verdict);
    }
    text
}
