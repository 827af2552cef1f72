//! The command that tests whole renders: `validate scenes`.

use crate::console::{percentage, print, write};
use crate::crew::{ask_and_print, unanswered};
use crate::documents::Documents;
use crate::provenance::Provenance;
use crate::stage::asked_again;
use crate::{closed_forms, metamorphic, references};
use std::error::Error;
use std::path::PathBuf;
use validation::{Report, Verdict};

#[derive(clap::Args)]
pub struct Arguments {
    /// Only scenes whose name contains this
    name: Option<String>,
    /// Samples a pixel
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Largest relative difference of a channel's mean that is none
    #[arg(long, default_value = "0.5%", value_parser = percentage)]
    margin: f64,
    /// Another number, other seeds
    #[arg(long, default_value_t = 0, value_parser = crate::console::number)]
    number: u64,
    /// 64 times the samples of closed forms; relations four times as fine
    #[arg(long)]
    thorough: bool,
    /// Write the tables of closed forms and relations
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    #[command(flatten)]
    documents: Documents,
}

/// Compares Etalon with the stored references, closed forms and metamorphic relations.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn Error>> {
    let Arguments { name, spp, margin, number, thorough, markdown, documents } = arguments;
    documents.check_writable(&[], &[&markdown])?;
    let mut outcomes = vec![];
    for reference in references::references(&references::folder())? {
        if name.as_ref().is_none_or(|n| reference.name.contains(n)) {
            let outcome = asked_again(number, |number| reference.check(spp, margin, number))
                .unwrap_or_else(|error| unanswered(&reference.name, error));
            print(&outcome);
            outcomes.push(outcome);
        }
    }
    let chosen = |other: &str| name.as_ref().is_none_or(|n| other.contains(n));
    let effort = if thorough { 64 } else { 1 };
    let cases: Vec<_> = closed_forms::cases().into_iter().filter(|case| chosen(&case.name)).collect();
    let known = ask_and_print(
        &cases,
        |case| &case.name,
        |case| asked_again(number, |number| case.check(effort, number)).map(Some),
    )?;
    let relations: Vec<_> = metamorphic::relations()
        .into_iter()
        .filter(|relation| chosen(&relation.name))
        .map(|relation| if thorough { relation.thorough() } else { relation })
        .collect();
    let related = ask_and_print(
        &relations,
        |relation| &relation.name,
        |relation| asked_again(number, |number| relation.check(1, number)).map(Some),
    )?;
    outcomes.extend(known.iter().chain(&related).cloned());
    if outcomes.is_empty() {
        return Err("there is no such scene".into());
    }
    let cases: Vec<_> = cases.into_iter().zip(known).collect();
    let relations: Vec<_> = relations.into_iter().zip(related).collect();
    write(markdown.as_deref(), || Ok(closed_forms::markdown(&Provenance::here(), &cases, &relations)))?;
    documents.finish(Report::new("scenes", outcomes))
}
