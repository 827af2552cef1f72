//! A page for tests.

use super::evidence::Evidence;
use super::histogram::Histogram;
use super::page::page;
use super::pictures::Pictures;
use super::strip::Still;
use crate::museum::findings::{Fate, Finding, Findings};
use crate::provenance::Provenance;
use validation::{Outcome, Verdict};

/// A page with something awkward in each section.
pub fn sample() -> String {
    let outcome = |check: &str, verdict, subject: &str| {
        let message = "<script>alert('&')</script> ".repeat(4);
        Outcome::new(check, verdict, message)
            .of(subject)
            .p_value(0.3)
            .figure("sampled", 0.9)
            .figure("integrated", 0.9)
    };
    let checks = validation::checks::CHECKS.iter();
    let materials: Vec<Outcome> = checks
        .flat_map(|check| {
            (0..30).map(|i| (check.name, format!("a-rather-long-material[{i}]::{}::35", check.name)))
        })
        .map(|(check, subject)| outcome(check, Verdict::Equivalent, &subject))
        .collect();
    let evidence = Evidence {
        sampling: materials[..3].to_vec(),
        materials,
        furnace: vec![outcome("furnace", Verdict::Equivalent, "glass[<1>]::furnace::30")],
        references: vec![outcome("images", Verdict::Inconclusive, "scene::rgb")],
        closed_forms: vec![outcome(
            "closed form",
            Verdict::Different,
            "a-long::name-of-a-case-that-does-not-wrap-easily",
        )],
        relations: vec![outcome("relation", Verdict::Equivalent, "b::c")],
        stability: vec![outcome("stability", Verdict::Equivalent, "light::<stiff>")],
        origins: vec!["<origin>".into()],
    };
    let histogram =
        Histogram { name: "<model>".into(), samples: 9, observed: vec![4.0, 5.0], expected: vec![4.5; 2] };
    let pixel = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==".to_string();
    let [name, message] = ["<scene>", "<message>"].map(String::from);
    let stills = vec![Still { name: "light::<still>".into(), picture: pixel.clone() }; 12];
    let picture = Pictures { name, message, mitsuba: pixel.clone(), etalon: pixel.clone(), scores: pixel };
    let source = "tungsten #54 https://github.com/tunabrain/tungsten/issues/54".to_string();
    let [program, test, file, commit] = ["<program>", "<test>", "<file>", "<commit>"].map(String::from);
    let fate = Fate::Killed { program, test, seconds: 1.0 };
    let bug =
        Finding { name: "<bug>".into(), about: "<about>".into(), source, file, commit: commit.clone(), fate };
    let made = Provenance { date: "<date>".into(), machine: "<machine>".into(), commit };
    let findings = Findings { made, bugs: vec![bug] };
    page(&evidence, &[histogram], (&[picture], &stills), Some(&findings), &[("processor", "<cpu>".into())])
}
