//! The sections of the page that are tables and plots of outcomes.

use super::charts::{Chart, figure, legend, ticks};
use super::histogram::Histogram;
use super::matrix::{class, sign};
use crate::museum::findings::{Fate, Finding, Findings};
use std::collections::BTreeMap;
use validation::html::escape;
use validation::statistics::uniformity;
use validation::{Outcome, Verdict};

/// The overall verdict, and the number of outcomes of each.
pub fn summary(outcomes: &[&Outcome]) -> String {
    let count = |verdict| outcomes.iter().filter(|outcome| outcome.verdict == verdict).count();
    let worst = Verdict::all(outcomes.iter().map(|outcome| outcome.verdict));
    let sentence = match worst {
        Verdict::Equivalent => "Everything that was asked holds.",
        Verdict::Inconclusive => "Nothing differs; some answers need more samples.",
        Verdict::Different => "Something differs.",
    };
    let tile = |(verdict, name)| {
        format!("<div class=\"{}\"><b>{} {}</b>{name}</div>", class(verdict), sign(verdict), count(verdict))
    };
    let tiles = [
        (Verdict::Equivalent, "hold"),
        (Verdict::Different, "differ"),
        (Verdict::Inconclusive, "inconclusive"),
    ];
    format!(
        "<div class=\"verdict {}\"><b>{} {sentence}</b></div><div class=\"counts\">{}</div>",
        class(worst),
        sign(worst),
        tiles.map(tile).concat()
    )
}

/// One line for each outcome.
pub fn table(outcomes: &[Outcome]) -> String {
    let row = |outcome: &Outcome| {
        let (class, sign, verdict) = (class(outcome.verdict), sign(outcome.verdict), outcome.verdict);
        let [subject, message] = [&outcome.subject, &outcome.message].map(|text| escape(text));
        format!(
            "<tr><th scope=\"row\">{subject}</th><td class=\"{class}\">{sign} {verdict}</td><td>{message}</td></tr>"
        )
    };
    let rows: String = outcomes.iter().map(row).collect();
    format!(
        "<div class=\"wide\"><table class=\"answers\"><thead><tr><th>what</th><th>verdict</th><th>found</th></tr></thead><tbody>{rows}</tbody></table></div>"
    )
}

/// Every outcome that does not hold, worst first.
pub fn exceptions<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> String {
    let mut rest: Vec<Outcome> = outcomes.filter(|o| o.verdict != Verdict::Equivalent).cloned().collect();
    rest.sort_by_key(|outcome| std::cmp::Reverse(outcome.verdict));
    if rest.is_empty() { "<p>Everything holds.</p>".into() } else { table(&rest) }
}

/// Observed and expected counts, with a sentence about the residuals.
pub fn histograms(histograms: &[Histogram]) -> String {
    let drawn = histograms.iter().map(|histogram| {
        let most = histogram.observed.iter().chain(&histogram.expected).fold(1.0f64, |a, b| a.max(*b));
        let xs: Vec<_> = (0..=6).map(|i| f64::from(i) * 30.0).map(|v| (v, format!("{v}°"))).collect();
        let step = 180.0 / histogram.observed.len() as f64;
        let mut chart = Chart::new([0.0, 180.0], [0.0, 1.05 * most]).axes(
            &xs,
            &ticks(most),
            ["angle from the normal", "samples"],
        );
        for (i, (observed, expected)) in histogram.observed.iter().zip(&histogram.expected).enumerate() {
            let at = |share: f64| (i as f64 + share) * step;
            chart = chart.bar([at(0.05), at(0.5)], *observed, 0).bar([at(0.5), at(0.95)], *expected, 1);
        }
        let residuals: Vec<f64> = histogram.residuals().into_iter().flatten().collect();
        let largest = residuals.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let caption = format!(
            "{}{} samples; the largest of {} residuals is {largest:.2} standard deviations.",
            legend(["observed", "expected"]),
            histogram.samples,
            residuals.len()
        );
        figure(&histogram.name, &chart.svg("observed and expected counts"), &caption)
    });
    format!("<div class=\"figures\">{}</div>", drawn.collect::<String>())
}

/// Albedo over the angle: a plot for each model, a line for each parameter; dots are sampled, lines are
/// integrated.
pub fn albedos(cells: &[Outcome]) -> String {
    /// Outcomes by angle in degrees.
    type Angles<'a> = Vec<(f64, &'a Outcome)>;
    let mut models: BTreeMap<&str, BTreeMap<&str, Angles>> = BTreeMap::new();
    for cell in cells {
        let model = cell.subject.split("::").next().unwrap_or_default();
        let angle = cell.subject.rsplit("::").next().and_then(|angle| angle.parse().ok());
        let (name, parameters) = model.split_once('[').unwrap_or((model, ""));
        if let Some(angle) = angle {
            let lines = models.entry(name).or_default();
            lines.entry(parameters.trim_end_matches(']')).or_default().push((angle, cell));
        }
    }
    let drawn = models.iter().map(|(name, lines)| {
        let xs: Vec<_> = (0..=6).map(|i| f64::from(i) * 15.0).map(|v| (v, format!("{v}°"))).collect();
        let mut chart =
            Chart::new([0.0, 90.0], [0.0, 1.05]).axes(&xs, &ticks(1.0), ["angle of incidence", "albedo"]);
        for (series, points) in lines.values().enumerate() {
            let value = |cell: &Outcome, figure: &str| cell.figures.get(figure).copied().unwrap_or(f64::NAN);
            let delta = |cell: &Outcome| value(cell, "sampled") - value(cell, "sampled_smooth");
            let height = |cell: &Outcome| value(cell, "integrated") + delta(cell);
            chart = chart.line(points.iter().map(|(angle, cell)| [*angle, height(cell)]), series);
            for (angle, cell) in points {
                chart = chart.dot([*angle, value(cell, "sampled")], series);
            }
        }
        figure(name, &chart.svg("albedo over the angle of incidence"), &legend(lines.keys().copied()))
    });
    format!("<div class=\"figures\">{}</div>", drawn.collect::<String>())
}

/// Histogram of all p-values in twentieths; uniform if the checks are correct and Etalon is.
pub fn p_values(outcomes: &[&Outcome]) -> String {
    const BINS: usize = 20;
    let values: Vec<f64> =
        outcomes.iter().filter_map(|o| o.p_value).filter(|p| (0.0..=1.0).contains(p)).collect();
    let mut counts = [0.0; BINS];
    values.iter().for_each(|p| counts[((p * BINS as f64) as usize).min(BINS - 1)] += 1.0);
    let (most, even) = (counts.iter().fold(1.0f64, |a, b| a.max(*b)), values.len() as f64 / BINS as f64);
    let xs: Vec<_> = (0..=5).map(|i| f64::from(i) * 0.2).map(|v| (v, format!("{v:.1}"))).collect();
    let mut chart =
        Chart::new([0.0, 1.0], [0.0, 1.05 * most]).axes(&xs, &ticks(most), ["p-value", "outcomes"]);
    for (i, count) in counts.iter().enumerate() {
        chart = chart.bar([0.0, 1.0].map(|side| (i as f64 + side) / BINS as f64), *count, 0);
    }
    let chart = chart.line([[0.0, even], [1.0, even]], 1);
    let caption = format!(
        "{}{} p-values; Kolmogorov and Smirnov's test of uniformity: p = {:.3}.",
        legend(["observed", "uniform"]),
        values.len(),
        uniformity(&values)
    );
    figure("All p-values", &chart.svg("histogram of p-values"), &caption)
}

/// The table of planted bugs with the test that detected each.
pub fn museum(findings: Option<&Findings>) -> String {
    let Some(findings) = findings else { return "<p>No results are committed.</p>".into() };
    let (killed, all) = findings.killed();
    let row = |bug: &Finding| {
        let (verdict, fate) = match &bug.fate {
            Fate::Killed { test, .. } => (Verdict::Equivalent, escape(test)),
            Fate::Survived => (Verdict::Different, "not noticed".into()),
            Fate::DoesNotCompile => (Verdict::Inconclusive, "does not compile".into()),
        };
        let [name, about, source] = [&bug.name, &bug.about, &bug.source].map(|text| escape(text));
        format!(
            "<tr><th scope=\"row\">{name}</th><td>{about}</td><td class=\"{}\">{} {fate}</td><td>{source}</td></tr>",
            class(verdict),
            sign(verdict)
        )
    };
    let rows: String = findings.bugs.iter().map(row).collect();
    format!(
        "<p>{killed} of {all} planted bugs were noticed ({}).</p><div class=\"wide\"><table><thead><tr><th>bug</th><th>what it does</th><th>noticed by</th><th>after</th></tr></thead><tbody>{rows}</tbody></table></div>",
        escape(
            &[&findings.made.date, &findings.made.machine, &findings.made.commit]
                .map(String::as_str)
                .join(" · ")
        )
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delta_lobes_count_in_albedo_curves() {
        let cell = Outcome::new("furnace", Verdict::Equivalent, "").of("glass[1.5]::furnace::0");
        let cell = cell.figure("sampled", 1.0).figure("sampled_smooth", 0.0).figure("integrated", 0.0);
        let steep = cell.clone().of("glass[1.5]::furnace::45");
        let html = albedos(&[cell, steep]);
        // In a range up to 1.05 an albedo of 1 is at y = 202 − 192/1.05.
        assert!(html.contains("points=\"46.0,19.1 229.0,19.1\"") && html.contains("1.5</span>"), "{html}");
    }

    #[test]
    fn only_what_does_not_hold_is_an_exception() {
        let of = |verdict, name: &str| Outcome::new("x", verdict, "").of(name);
        let all = [of(Verdict::Equivalent, "a"), of(Verdict::Inconclusive, "b"), of(Verdict::Different, "c")];
        let html = exceptions(all.iter());
        assert!(!html.contains(">a<") && html.find(">c<") < html.find(">b<"), "{html}");
        assert!(exceptions(all[..1].iter()).contains("Everything holds"));
    }
}
