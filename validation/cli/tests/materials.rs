//! Every material × example × check × direction, each a test of its own.

use libtest_mimic::{Arguments, Trial};
use std::sync::Arc;
use validate::trial::{Tally, effort};
use validate::{limits, materials};

/// Enough to see a few per cent of wrong density in any lobe; `validate bsdf --samples` asks for more.
const SAMPLES: usize = 1 << 17;

/// Needles and indices next to 1 want more samples: 47 of 3507.
const MOST_UNDECIDED: f64 = 0.02;

fn main() {
    let arguments = Arguments::from_args();
    let all = [materials::trials(None), limits::trials(None)].concat();
    // The whole suite errs once in a hundred runs over other seeds.
    let effort = effort(SAMPLES, all.len(), false);
    let tally = Arc::new(Tally::default());
    let test = |trial: validate::trial::Trial| {
        let tally = tally.clone();
        Trial::test(trial.name.clone(), move || Ok(tally.judge(trial.run(&effort, 0)?)?))
    };
    let conclusion = libtest_mimic::run(&arguments, all.into_iter().map(test).collect());
    tally.exit_if_undecided(MOST_UNDECIDED);
    conclusion.exit();
}
