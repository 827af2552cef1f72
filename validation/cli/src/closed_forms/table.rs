//! The table of cases with what was measured, as `docs/closed-forms.md` shows it.

use super::ClosedForm;
use std::fmt::Write;
use validation::Outcome;

/// A Markdown table, a case a row.
pub fn markdown(cases: &[(ClosedForm, Outcome)]) -> String {
    let mut text = String::from(
        "| case | formula and source | expected | measured − expected (99 % interval) | margin | verdict |\n\
         |---|---|--:|--:|--:|---|\n",
    );
    for (case, outcome) in cases {
        let figure = |name: &str| {
            let value = outcome.figures.get(name).copied().unwrap_or(f64::NAN);
            100.0 * (value - 1.0)
        };
        let [deviation, low, high] = ["ratio", "ratio.low", "ratio.high"].map(figure);
        let (source, margin) = (case.source.replace('|', "\\|"), 100.0 * case.margin);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {source} | {:.6} | {deviation:+.4} % ({low:+.4} to {high:+.4}) | {margin} % | {} |",
            case.name, case.expected, outcome.verdict
        );
    }
    text
}
