//! `fuzz scenes`

use super::record::Record;
use super::{files, range};
use fuzz::scenes::judge::{Answer, Failure, Judgement, judge};
use fuzz::scenes::mitsuba::Mitsuba;
use fuzz::scenes::{grammar, models::Models};
use std::collections::BTreeMap;
use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;
use validate::console::say;

#[derive(clap::Args)]
pub struct Arguments {
    /// Numbers of the scenes
    #[arg(long, default_value = "0..500", value_delimiter = ',', value_parser = range)]
    numbers: Vec<Range<u64>>,
    /// Samples of a pixel, at most
    #[arg(long, default_value_t = 1 << 14, value_parser = clap::value_parser!(u32).range(64..=1 << 24))]
    samples: u32,
    /// Where scenes that differ are left, and the record
    #[arg(long, default_value = "target/fuzzed-scenes")]
    folder: PathBuf,
}

impl Arguments {
    pub fn run(self) -> Result<bool, Box<dyn Error>> {
        let Self { numbers, samples, folder } = self;
        let mut record = Record::within(&folder)?;
        let (models, files) = (Models::read()?, files());
        let mut mitsuba = Mitsuba::start()?;
        let mut counts: BTreeMap<Answer, u32> = BTreeMap::new();
        for number in numbers.into_iter().flatten() {
            let scene = grammar::scene(&models, &files.to_string_lossy(), number)
                .ok_or("the grammar has a dead end")?;
            let found: Judgement = match judge(&scene, number, &folder, &mut mitsuba, samples) {
                Ok(found) => found,
                Err(Failure::Mitsuba(words)) => {
                    mitsuba = Mitsuba::start()?;
                    Judgement::died(&scene, number, words)
                }
                Err(Failure::Own(words)) => return Err(words.into()),
            };
            if found.answer != Answer::RefusedByBoth {
                let Judgement { answer, samples, message, .. } = &found;
                say(format_args!("{number}: {answer:?} with {samples} samples: {message}"));
            }
            *counts.entry(found.answer).or_default() += 1;
            record.add(&found)?;
        }
        if counts.is_empty() {
            return Err("there is no number in that range".into());
        }
        let counts_said: Vec<String> =
            counts.iter().map(|(answer, count)| format!("{count} {answer:?}")).collect();
        say(format_args!("{}", counts_said.join(", ")));
        Ok(counts.keys().all(|answer| answer.is_clean()))
    }
}
