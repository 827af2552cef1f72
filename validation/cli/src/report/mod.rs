//! `validate report`: all results of the harness about Etalon, on one self-contained page.
//!
//! `evidence` runs the trials that `questions` selects, `pictures` and `histogram` illustrate them, `page`
//! assembles them. To add a section: a function that returns HTML, and its line in `page`.

#[cfg(test)]
mod browser;
mod charts;
pub mod command;
mod evidence;
mod histogram;
pub(crate) mod machine;
mod matrix;
mod page;
pub(crate) mod pictures;
mod questions;
#[cfg(test)]
mod sample;
mod sections;
mod strip;

use crate::museum::findings::{Findings, results};
use evidence::Evidence;
use std::path::Path;
use validation::Verdict;

/// The effort of a report.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Samples per check.
    pub samples: usize,
    /// Samples per pixel of the reference scenes.
    pub spp: u32,
    /// Whether only one is run of the trials, closed forms and relations that differ in direction or
    /// parameter only.
    pub sparse: bool,
}

impl Effort {
    /// The effort of a full report.
    pub const USUAL: Self = Self { samples: 1 << 17, spp: 1024, sparse: false };
    /// The effort of a quick overview.
    pub const QUICK: Self = Self { samples: 1 << 15, spp: 128, sparse: true };
}

/// Writes the page to `out`, after testing that it can be written there. Outcomes in the JSON documents of
/// `from` are not computed again. `say` gets each step.
pub fn write(out: &Path, from: Option<&Path>, effort: Effort, say: fn(&str)) -> Result<Verdict, String> {
    etalon::files::check_writable(out).map_err(|e| e.to_string())?;
    let evidence = Evidence::gather(from, effort, say)?;
    say("histograms");
    let histograms = histogram::histograms(effort.samples)?;
    say("pictures");
    let pictures = pictures::pictures(effort)?;
    let stills = strip::stills(effort)?;
    let file = results();
    let findings = if file.exists() { Some(Findings::read(&file)?) } else { None };
    let page = page::page(&evidence, &histograms, (&pictures, &stills), findings.as_ref(), &machine::here());
    etalon::files::write_file(out, page.as_bytes()).map_err(|e| e.to_string())?;
    Ok(evidence.verdict())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_cannot_be_written_is_refused_before_anything_is_asked() {
        let out = Path::new("/nonexistent/report.html");
        let refused = write(out, None, Effort::QUICK, |step| panic!("{step}"));
        assert!(refused.is_err_and(|error| error.contains("report.html: cannot write")));
    }
}
