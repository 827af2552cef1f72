//! The page: its sections in their order, with the style sheet and the script inline.

use super::evidence::Evidence;
use super::histogram::Histogram;
use super::matrix::matrix;
use super::pictures::Pictures;
use super::sections;
use super::strip::{self, Still};
use crate::museum::findings::Findings;
use validation::Outcome;
use validation::html::escape;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

struct Section {
    id: &'static str,
    title: &'static str,
    about: &'static str,
    body: String,
}

/// The whole page.
pub fn page(
    evidence: &Evidence,
    histograms: &[Histogram],
    (pictures, stills): (&[Pictures], &[Still]),
    findings: Option<&Findings>,
    machine: &[(&str, String)],
) -> String {
    let section = |id, title, about, body| Section { id, title, about, body };
    let outcomes: Vec<&Outcome> = evidence.outcomes().collect();
    let pictures: String = pictures.iter().map(Pictures::html).collect();
    let sections = [
        section(
            "exceptions",
            "What does not hold",
            "Everything different or inconclusive. Checks share a level of 1 %; an inconclusive answer says what it could not have noticed.",
            sections::exceptions(evidence.outcomes()),
        ),
        section(
            "materials",
            "Materials",
            "Model × check. A cell counts the directions that hold, and gives the smallest p-value, else the smallest effect that would be noticed; its tooltip has the worst message.",
            matrix(&evidence.materials),
        ),
        section(
            "sampling",
            "Light, lenses, filters, warps",
            "The same checks on all else that is drawn.",
            matrix(&evidence.sampling),
        ),
        section(
            "histograms",
            "Samples and densities",
            "Counts of sampled directions beside what the density promises, seen from 35°. The check chi2 decides on finer bins.",
            sections::histograms(histograms),
        ),
        section(
            "albedo",
            "Albedo",
            "What comes back of the light that arrives. Lines are integrated, dots sampled; single scattering loses light on rough surfaces, and a smooth interface none.",
            sections::albedos(&evidence.furnace),
        ),
        section(
            "pictures",
            "Pictures",
            "Flip between Mitsuba's image, Etalon's, and their signed z-scores: red where Etalon is brighter, blue where darker, full colour at five standard errors.",
            format!("<div class=\"figures\">{pictures}</div>"),
        ),
        section(
            "references",
            "Reference scenes",
            "Etalon against images that Mitsuba made: every channel's mean within ±0.5 %, every tile within its noise.",
            sections::table(&evidence.references),
        ),
        section(
            "closed-forms",
            "Closed forms",
            "Scenes whose image has an analytic answer: the 99 % interval must lie in the margin.",
            sections::table(&evidence.closed_forms),
        ),
        section(
            "relations",
            "Metamorphic relations",
            "Pairs of renders that must be alike whatever the true image is.",
            sections::table(&evidence.relations),
        ),
        section(
            "stability",
            "Stiff and extreme scenes",
            "Every case states what is expected, a figure and a verdict. The pictures are what their cameras see, where that is more than one pixel.",
            strip::html(stills) + &sections::table(&evidence.stability),
        ),
        section(
            "p-values",
            "p-values",
            "Right code and honest tests give p-values that are uniform, or conservative where counts are few.",
            format!("<div class=\"figures\">{}</div>", sections::p_values(&outcomes)),
        ),
        section(
            "museum",
            "Bug museum",
            "Bugs planted one at a time, and the test that noticed.",
            sections::museum(findings),
        ),
        section(
            "machine",
            "Machine and run",
            "What was asked, and where.",
            facts(machine, &evidence.origins),
        ),
    ];
    let links: String = sections.iter().map(|s| format!("<a href=\"#{}\">{}</a>", s.id, s.title)).collect();
    let body: String = sections
        .iter()
        .map(|s| {
            format!("<section id=\"{}\"><h2>{}</h2><p>{}</p>{}</section>\n", s.id, s.title, s.about, s.body)
        })
        .collect();
    let summary = sections::summary(&outcomes);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>Etalon: validation report</title>\
         <style>{STYLE}</style></head><body>\n<header><h1>Etalon: validation report</h1>{summary}<nav>{links}</nav></header>\n\
         <main>{body}</main><script>{SCRIPT}</script></body></html>\n"
    )
}

fn facts(machine: &[(&str, String)], origins: &[String]) -> String {
    let fact =
        |(name, value): &(&str, String)| format!("<dt>{}</dt><dd>{}</dd>", escape(name), escape(value));
    let facts: String = machine.iter().map(fact).collect();
    let origins: String = origins.iter().map(|origin| format!("<li>{}</li>", escape(origin))).collect();
    format!("<dl>{facts}</dl><ul>{origins}</ul>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample::sample;

    #[test]
    fn text_from_outside_stays_text() {
        let page = sample();
        for text in [
            "<script>alert",
            "<origin>",
            "<model>",
            "<scene>",
            "<still>",
            "<stiff>",
            "<message>",
            "<bug>",
            "<about>",
            "<test>",
            "<date>",
            "<machine>",
            "<cpu>",
            "<1>",
        ] {
            assert!(!page.contains(text), "{text}");
            assert!(page.contains(&escape(text)), "{text} is missing");
        }
    }

    #[test]
    fn every_section_is_there_with_the_verdict_first() {
        let page = sample();
        let ids = [
            "exceptions",
            "materials",
            "sampling",
            "histograms",
            "albedo",
            "pictures",
            "references",
            "closed-forms",
            "relations",
            "stability",
            "p-values",
            "museum",
            "machine",
        ];
        for id in ids {
            assert!(
                page.contains(&format!("<section id=\"{id}\">")) && page.contains(&format!("href=\"#{id}\"")),
                "{id}"
            );
        }
        assert!(page.find("Something differs.") < page.find("<section") && page.contains("✗ 1</b>differ"));
    }

    #[test]
    fn nothing_comes_from_elsewhere() {
        let page = sample();
        let addresses = ["src=\"", "href=\""].iter().flat_map(|attribute| page.split(attribute).skip(1));
        let mut count = 0;
        for address in addresses {
            assert!(address.starts_with('#') || address.starts_with("data:"), "{}", &address[..40]);
            count += 1;
        }
        assert!(
            count >= 15 && !page.contains("url(") && !page.contains("@import") && !page.contains("<link")
        );
    }
}
