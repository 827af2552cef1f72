//! `fuzz techniques`

use super::record::Record;
use super::{files, range};
use etalon::files::write_file;
use fuzz::scenes::models::Models;
use fuzz::techniques::{Finding, judge};
use std::collections::BTreeMap;
use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;
use validate::console::say;
use validation::Verdict;

#[derive(clap::Args)]
pub struct Arguments {
    /// Numbers of the scenes
    #[arg(long, default_value = "0..100", value_delimiter = ',', value_parser = range)]
    numbers: Vec<Range<u64>>,
    /// Samples of a pixel; what differs is confirmed with four times as many
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u64).range(64..=1 << 24))]
    samples: u64,
    /// Where scenes that differ are left, and the record
    #[arg(long, default_value = "target/fuzzed-techniques")]
    folder: PathBuf,
}

impl Arguments {
    pub fn run(self) -> Result<bool, Box<dyn Error>> {
        let Self { numbers, samples, folder } = self;
        let mut record = Record::within(&folder)?;
        let models = Models::read()?;
        let mut counts: BTreeMap<(&str, Verdict), u32> = BTreeMap::new();
        let mut clean = true;
        for number in numbers.into_iter().flatten() {
            for found in judge(&models, &files().to_string_lossy(), number, samples)? {
                let Finding { technique, verdict, message, text, .. } = &found;
                *counts.entry((technique, *verdict)).or_default() += 1;
                if *verdict == Verdict::Different {
                    clean = false;
                    let name = folder.join(format!("{number} {technique}.xml"));
                    write_file(&name, text.as_bytes())?;
                    say(format_args!("{number}, {technique}: {message}"));
                }
                record.add(&found)?;
            }
        }
        if counts.is_empty() {
            return Err("there is no number in that range".into());
        }
        for ((technique, verdict), count) in counts {
            say(format_args!("{technique}: {count} {verdict:?}"));
        }
        Ok(clean)
    }
}
