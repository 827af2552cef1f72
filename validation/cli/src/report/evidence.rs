//! The outcomes that a report shows: computed now, or read from JSON documents of earlier runs.

use super::Effort;
use super::questions::{judge, one_of_a_family, thin};
use crate::files;
use crate::stage::asked_again;
use crate::trial::{effort, effort_of_sampling};
use crate::{closed_forms, furnace, limits, materials, metamorphic, references, sampling, stability};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use validation::report::Report;
use validation::{Outcome, Verdict, checks};

/// Largest relative difference of a reference's means that counts as equivalent.
pub const MARGIN: f64 = 0.005;

/// Prefixes of the furnace cells whose albedo is plotted.
const CURVES: [&str; 3] = ["roughconductor-ggx[", "roughdielectric-ggx[", "dielectric-exact["];

/// All outcomes, by their subject.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    pub materials: Vec<Outcome>,
    pub sampling: Vec<Outcome>,
    pub furnace: Vec<Outcome>,
    pub references: Vec<Outcome>,
    pub closed_forms: Vec<Outcome>,
    pub relations: Vec<Outcome>,
    pub stability: Vec<Outcome>,
    /// A sentence about each group of outcomes: what was run or read.
    pub origins: Vec<String>,
}

impl Evidence {
    /// Reads the documents below `from`, and runs what they do not contain. `say` gets each step.
    pub fn gather(from: Option<&Path>, effort: Effort, say: fn(&str)) -> Result<Self, String> {
        let mut evidence = Self::default();
        for document in from.map_or(Ok(vec![]), read)? {
            evidence.add(document);
        }
        if evidence.materials.is_empty() {
            say("materials");
            let trials = thin([materials::trials(None), limits::trials(None)].concat(), effort.sparse);
            let each = self::effort(effort.samples, trials.len(), false);
            evidence.materials = judge(&trials, |trial| &trial.name, |trial| trial.run(&each, 0))?;
            evidence.origin("materials", trials.len(), &format!("{} samples each", effort.samples));
        }
        if evidence.sampling.is_empty() {
            say("sampling");
            let trials = thin(sampling::trials(None), effort.sparse);
            let each = effort_of_sampling(effort.samples, trials.len(), false);
            evidence.sampling = judge(&trials, |trial| &trial.name, |trial| trial.run(&each, 0))?;
            evidence.origin(
                "light, lenses, filters, warps",
                trials.len(),
                &format!("{} samples each", effort.samples),
            );
        }
        if evidence.furnace.is_empty() {
            say("furnace");
            let mut cells: Vec<furnace::Cell> =
                CURVES.iter().flat_map(|name| furnace::cells(Some(name))).collect();
            cells.retain(|cell| cell.name.starts_with("roughconductor") || cell.name.contains("1.5000]"));
            let each = checks::Effort { albedo: 1e-3, ..self::effort(effort.samples, cells.len(), false) };
            evidence.furnace = judge(&cells, |cell| &cell.name, |cell| cell.run(&each, 0).map(Some))?;
            evidence.origin("furnace", cells.len(), &format!("{} samples each", effort.samples));
        }
        if evidence.references.is_empty() {
            say("references");
            for reference in references::references(&references::folder())? {
                evidence
                    .references
                    .push(asked_again(0, |number| reference.check(effort.spp, MARGIN, number))?);
            }
            evidence.origin(
                "references",
                evidence.references.len(),
                &format!("{} samples a pixel", effort.spp),
            );
        }
        if evidence.closed_forms.is_empty() {
            say("closed forms");
            let cases = one_of_a_family(closed_forms::cases(), |case| &case.name, effort.sparse);
            evidence.closed_forms = judge(
                &cases,
                |case| &case.name,
                |case| asked_again(0, |number| case.check(1, number)).map(Some),
            )?;
            evidence.origin("closed forms", cases.len(), "12 renders each");
        }
        if evidence.relations.is_empty() {
            say("relations");
            let relations = one_of_a_family(metamorphic::relations(), |r| &r.name, effort.sparse);
            evidence.relations = judge(
                &relations,
                |relation| &relation.name,
                |relation| asked_again(0, |number| relation.check(1, number)).map(Some),
            )?;
            evidence.origin("metamorphic relations", relations.len(), "as in the tests");
        }
        say("stiff and extreme scenes");
        let cases = one_of_a_family(stability::cases(), |case| &case.name, effort.sparse);
        let ask = |case: &stability::Case| Ok(Some(case.check(1, 0).outcome()));
        evidence.stability = judge(&cases, |case| &case.name, ask)?;
        evidence.origin("stiff and extreme scenes", cases.len(), "as in the tests");
        Ok(evidence)
    }

    /// All outcomes.
    pub fn outcomes(&self) -> impl Iterator<Item = &Outcome> {
        let Self { materials, sampling, furnace, references, closed_forms, relations, stability, .. } = self;
        [materials, sampling, furnace, references, closed_forms, relations, stability].into_iter().flatten()
    }

    /// The worst verdict of all outcomes.
    pub fn verdict(&self) -> Verdict {
        Verdict::all(self.outcomes().map(|outcome| outcome.verdict))
    }

    fn origin(&mut self, what: &str, count: usize, how: &str) {
        self.origins.push(format!("{what}: {count} asked now, {how}"));
    }

    fn add(&mut self, Document { origin, report }: Document) {
        self.origins.push(origin);
        match report.title.as_str() {
            "materials" => self.materials.extend(report.outcomes),
            "sampling" => self.sampling.extend(report.outcomes),
            "furnace" => self.furnace.extend(report.outcomes),
            _ => {
                let related: BTreeSet<String> =
                    metamorphic::relations().into_iter().map(|r| r.name).collect();
                for outcome in report.outcomes {
                    let place = match outcome.check.as_str() {
                        "closed form" => &mut self.closed_forms,
                        _ if related.contains(&outcome.subject) => &mut self.relations,
                        _ => &mut self.references,
                    };
                    place.push(outcome);
                }
            }
        }
    }
}

/// A document of an earlier run.
struct Document {
    /// A sentence about it.
    origin: String,
    report: Report,
}

/// The reports among the JSON documents of a folder, by name.
///
/// # Errors
/// If one cannot be read, if there is none, or if two of them are of one check of one subject.
fn read(folder: &Path) -> Result<Vec<Document>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<_> = entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    paths.sort();
    let (mut documents, mut seen) = (vec![], BTreeMap::new());
    for path in paths {
        let mut document: Value = files::json(&path)?;
        let known = ["materials", "sampling", "furnace", "scenes"];
        // Other documents may be of any form.
        if !document.get("title").and_then(Value::as_str).is_some_and(|title| known.contains(&title)) {
            continue;
        }
        if document.get("outcomes").is_none() {
            let name = path.display();
            return Err(format!(
                "{name}: a document without outcomes, as of --digest; expected one of --json"
            ));
        }
        // JSON has no NaN, so figures that are not finite are null.
        let outcomes = document.get_mut("outcomes").and_then(Value::as_array_mut);
        let figures = outcomes.into_iter().flatten().filter_map(|outcome| outcome.get_mut("figures"));
        for figures in figures.filter_map(Value::as_object_mut) {
            figures.retain(|_, value| !value.is_null());
        }
        let said = |name: &str| document.get(name).and_then(Value::as_str).unwrap_or("unknown").to_owned();
        let made = format!("{}, commit {}", said("date"), said("commit"));
        let report: Report =
            serde_json::from_value(document).map_err(|e| format!("{}: {e}", path.display()))?;
        let name = path.display();
        for outcome in &report.outcomes {
            let of = (outcome.check.clone(), outcome.subject.clone());
            if let Some(other) = seen.insert(of, path.clone()).filter(|other| *other != path) {
                let (check, subject) = (&outcome.check, &outcome.subject);
                return Err(format!("{name}: {check} of {subject} is in {} as well", other.display()));
            }
        }
        let origin =
            format!("{}: {} outcomes read from {name} ({made})", report.title, report.outcomes.len());
        documents.push(Document { origin, report });
    }
    if documents.is_empty() { Err(format!("{}: no report in it", folder.display())) } else { Ok(documents) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::report::to_json;

    #[test]
    fn documents_of_other_forms_are_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let report =
            to_json(&Report::new("scenes", vec![Outcome::new("x", Verdict::Equivalent, "")])).unwrap();
        for (name, text) in [("a", "[1, 2]"), ("b", "3"), ("c", "{\"title\": 1}"), ("d", &report)] {
            std::fs::write(folder.path().join(name).with_extension("json"), text).unwrap();
        }
        let found = read(folder.path()).unwrap();
        assert!(found.len() == 1 && found[0].origin.contains("d.json"), "{}", found[0].origin);
        std::fs::write(folder.path().join("e.json"), report).unwrap();
        assert!(
            read(folder.path()).is_err_and(|why| why.contains("e.json") && why.contains("d.json as well"))
        );
    }

    #[test]
    fn documents_are_sorted_into_their_sections() {
        let mut evidence = Evidence::default();
        let relation = metamorphic::relations()[0].name.clone();
        let outcomes = vec![
            Outcome::new("closed form", Verdict::Equivalent, "").of("a::b"),
            Outcome::new("images", Verdict::Different, "").of(relation),
            Outcome::new("images", Verdict::Inconclusive, "").of("cornell::rgb"),
        ];
        let report = Report::new("scenes", outcomes);
        evidence.add(Document { origin: String::new(), report });
        let counts = [evidence.closed_forms.len(), evidence.relations.len(), evidence.references.len()];
        assert_eq!((counts, evidence.verdict()), ([1; 3], Verdict::Different));
    }
}
