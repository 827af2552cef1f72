//! Agreement with Mitsuba 3.9.1: a test for every reference scene, spectral and rgb.
//!
//! A comparison errs for one of a hundred seeds, so one that fails is repeated with another seed and four
//! times the samples, and only a second failure counts: the suite errs in one of two hundred runs.
//!
//! The test takes fewer samples than `validate scenes`, and fails on a difference only. Whether the 99 %
//! interval lies within ±0.5 % is in the committed run of that command, `validation/results/scenes.json`.

use libtest_mimic::{Arguments, Trial};
use validate::references::{folder, references};
use validation::Verdict;

const SAMPLES: u32 = 256;
const MARGIN: f64 = 0.005;

fn main() {
    let arguments = Arguments::from_args();
    let tests = match references(&folder()) {
        Ok(found) => found,
        Err(message) => {
            eprintln!("{message}");
            std::process::exit(1);
        }
    };
    let tests = tests.into_iter().map(|reference| {
        Trial::test(reference.name.clone(), move || {
            for (samples, number) in [(SAMPLES, 0), (4 * SAMPLES, 1)] {
                let outcome = reference.check(samples, MARGIN, number)?;
                if outcome.verdict != Verdict::Different {
                    return Ok(());
                }
                eprintln!("{} samples: {}", samples, outcome.message);
            }
            Err("different twice".into())
        })
    });
    libtest_mimic::run(&arguments, tests.collect()).exit();
}
