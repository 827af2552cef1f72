//! The table of model × check: one cell for all directions, with the verdict as a sign, a colour and figures.

use std::collections::BTreeMap;
use validation::checks::CHECKS;
use validation::html::escape;
use validation::{Outcome, Verdict};

/// The sign of a verdict, for readers who cannot distinguish colours.
pub fn sign(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Equivalent => "✓",
        Verdict::Inconclusive => "?",
        Verdict::Different => "✗",
    }
}

/// The class of a verdict, for the style sheet.
pub fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Equivalent => "holds",
        Verdict::Inconclusive => "open",
        Verdict::Different => "differs",
    }
}

/// A table with a row for each subject, in their order, and a column for each check with outcomes.
pub fn matrix(outcomes: &[Outcome]) -> String {
    let mut subjects: Vec<&str> = vec![];
    let mut cells: BTreeMap<(&str, &str), Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes {
        let subject = outcome.subject.split("::").next().unwrap_or_default();
        if !subjects.contains(&subject) {
            subjects.push(subject);
        }
        cells.entry((subject, outcome.check.as_str())).or_default().push(outcome);
    }
    let asked = |check: &str| cells.keys().any(|(_, asked)| *asked == check);
    let checks: Vec<_> = CHECKS.iter().filter(|check| asked(check.name)).collect();
    let head: String = checks
        .iter()
        .map(|check| {
            format!("<th scope=\"col\" title=\"{}\">{}</th>", escape(check.about), escape(check.name))
        })
        .collect();
    let row = |subject: &&str| {
        let cells: String = checks.iter().map(|check| cell(cells.get(&(*subject, check.name)))).collect();
        format!("<tr><th scope=\"row\">{}</th>{cells}</tr>", escape(subject))
    };
    let body: String = subjects.iter().map(row).collect();
    format!(
        "<div class=\"wide\"><table class=\"matrix\"><thead><tr><th></th>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )
}

/// A cell: sign, number of outcomes that hold and of all, and the most informative figure; the worst message
/// as a tooltip.
fn cell(outcomes: Option<&Vec<&Outcome>>) -> String {
    let Some(worst) = outcomes.and_then(|outcomes| outcomes.iter().max_by_key(|o| o.verdict)) else {
        return "<td class=\"none\" title=\"does not apply\">–</td>".into();
    };
    let outcomes = outcomes.into_iter().flatten();
    let (asked, held) = outcomes.clone().fold((0, 0), |(asked, held), outcome| {
        (asked + 1, held + usize::from(outcome.verdict == Verdict::Equivalent))
    });
    let smallest = outcomes.filter_map(|outcome| outcome.p_value).reduce(f64::min);
    let figure = smallest
        .map_or_else(|| worst.detectable.map(|d| format!("±{d:.1e}")), |p| Some(format!("p {}", short(p))));
    format!(
        "<td class=\"{}\" title=\"{}\"><b>{} {held}/{asked}</b><small>{}</small></td>",
        class(worst.verdict),
        escape(&format!("{}: {}", worst.subject, worst.message)),
        sign(worst.verdict),
        figure.unwrap_or_else(|| "exact".into())
    )
}

fn short(p: f64) -> String {
    if p >= 0.001 || p == 0.0 { format!("{p:.3}") } else { format!("{p:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_shows_the_worst_of_its_directions() {
        let outcome = |verdict, p| Outcome::new("chi2", verdict, "<why>").of("glass[0]::chi2::0").p_value(p);
        let table = matrix(&[outcome(Verdict::Equivalent, 0.5), outcome(Verdict::Different, 1e-9)]);
        assert!(
            table.contains("class=\"differs\"") && table.contains("✗ 1/2") && table.contains("p 1e-9"),
            "{table}"
        );
        assert!(table.contains("&lt;why&gt;") && !table.contains("<why>"));
        assert!(!table.contains("furnace"), "a check that nothing was asked has no column");
    }
}
