//! The ledger of p-values: one JSON object a line, and whether all of them together are uniform.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use validation::report::{Outcome, Report};
use validation::statistics::{Verdict, uniformity};

/// Of the p-values of one check, the least probability at which they count as uniform.
const LEVEL: f64 = 0.001;

/// Appends the p-values of `outcomes` to a file.
pub fn append(path: &Path, outcomes: &[Outcome], number: u64) -> Result<(), String> {
    let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
    let mut file = file.map_err(|e| format!("{}: {e}", path.display()))?;
    for outcome in outcomes {
        let Some(p) = outcome.p_value else { continue };
        let mut parts = outcome.subject.split("::");
        let (subject, angle) = (parts.next().unwrap_or_default(), parts.last().unwrap_or_default());
        let (name, example) = subject.split_once('[').unwrap_or((subject, ""));
        let line = json!({
            "check": outcome.check, "subject": name, "example": example.trim_end_matches(']'), "angle": angle,
            "seed": number, "p": p,
        });
        writeln!(file, "{line}").map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// Reads a ledger and tests each check's p-values, and all together, for uniformity (Kolmogorov and Smirnov).
pub fn judge(path: &Path) -> Result<Report, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut checks: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (number, line) in text.lines().enumerate() {
        let wrong = || format!("{}:{}: expected an object with `check` and `p`", path.display(), number + 1);
        let value: Value = serde_json::from_str(line).map_err(|_| wrong())?;
        let check = value["check"].as_str().ok_or_else(wrong)?;
        let p = value["p"].as_f64().ok_or_else(wrong)?;
        for name in [check, "all"] {
            checks.entry(name.to_string()).or_default().push(p);
        }
    }
    let outcomes = checks.into_iter().map(|(check, values)| {
        let uniform = uniformity(&values);
        let verdict = if uniform > LEVEL { Verdict::Equivalent } else { Verdict::Different };
        let share = |limit: f64| values.iter().filter(|p| **p <= limit).count() as f64 / values.len() as f64;
        let message = format!(
            "{} p-values, of which {:.4} ≤ 0.01 and {:.4} ≤ 0.001; uniform: p = {uniform:.4}",
            values.len(),
            share(0.01),
            share(0.001)
        );
        Outcome::new("uniformity", verdict, message).of(check).figure("count", values.len() as f64)
    });
    Ok(Report::new("ledger", outcomes.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::statistics::Stream;

    #[test]
    fn a_ledger_of_uniform_values_holds_and_a_bent_one_does_not() {
        let path = std::env::temp_dir().join(format!("ledger-{}.jsonl", std::process::id()));
        for (power, verdict) in [(1.0, Verdict::Equivalent), (1.1, Verdict::Different)] {
            let mut stream = Stream::named("ledger", 0);
            let p_values = (0..10_000).map(|_| libm_pow(stream.uniform(), power));
            let outcome =
                |p| Outcome::new("chi2", Verdict::Equivalent, "").of("diffuse[0]::chi2::35").p_value(p);
            let outcomes: Vec<Outcome> = p_values.map(outcome).collect();
            append(&path, &outcomes, 3).unwrap();
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains(r#""example":"0""#) && text.contains(r#""angle":"35""#));
            assert_eq!(judge(&path).unwrap().verdict, verdict);
            std::fs::remove_file(&path).unwrap();
        }
    }

    fn libm_pow(x: f64, power: f64) -> f64 {
        etalon::math::function::exp(power * etalon::math::function::ln(x))
    }
}
