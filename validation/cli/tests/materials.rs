//! Every material × example × check × direction, each a test of its own.

use libtest_mimic::{Arguments, Trial};
use validate::materials::trials;
use validation::Verdict;
use validation::statistics::sidak;

/// Enough to see a few per cent of wrong density in any lobe; `validate bsdf --samples` asks for more.
const SAMPLES: usize = 1 << 17;

fn main() {
    let arguments = Arguments::from_args();
    let all = trials(None);
    // The whole suite errs once in a hundred runs over other seeds.
    let level = sidak(0.01, all.len());
    let tests = all.into_iter().map(|trial| {
        Trial::test(trial.name.clone(), move || match trial.run(SAMPLES, level, 0)? {
            Some(outcome) if outcome.verdict == Verdict::Different => Err(outcome.message.into()),
            _ => Ok(()),
        })
    });
    libtest_mimic::run(&arguments, tests.collect()).exit();
}
