//! `fuzz paths`

use super::files;
use fuzz::paths::{Record, follow};
use fuzz::scenes::models::Models;
use std::error::Error;
use std::path::PathBuf;
use validate::console::{say, write};
use validation::report::to_json;

#[derive(clap::Args)]
pub struct Arguments {
    /// Number of paths, at least: scenes are followed whole
    #[arg(long, default_value_t = 100_000_000, value_parser = clap::value_parser!(u64).range(1..))]
    paths: u64,
    /// The first scene
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Arguments {
    pub fn run(self) -> Result<bool, Box<dyn Error>> {
        let Self { paths, first, json } = self;
        // Written after every scene, so that results survive an interrupted run.
        let mut written = Ok(());
        let told = |record: &Record| written = write(json.as_deref(), || Ok(to_json(record)?));
        let record = follow(&Models::read()?, &files().to_string_lossy(), first, paths, told)?;
        written?;
        let Record { scenes, refused, paths, cut, not_finite, negative, first } = &record;
        say(format_args!(
            "{paths} paths in {scenes} scenes, {refused} more refused; {cut} cut, {not_finite} not finite, {negative} pixels negative"
        ));
        first.iter().for_each(|fault| say(format_args!("  {fault}")));
        Ok(first.is_empty())
    }
}
