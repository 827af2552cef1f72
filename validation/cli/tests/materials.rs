//! A test for every material × example × check × direction.

use libtest_mimic::{Arguments, Trial};
use std::sync::Arc;
use validate::trial::{Tally, effort};
use validate::{limits, materials};

/// Enough to detect an error of a few per cent of the density in any lobe; `validate bsdf --samples` takes
/// more.
const SAMPLES: usize = 1 << 17;

/// Largest share of inconclusive outcomes. Very narrow lobes and indices next to 1 need more samples: 47 of
/// 3507.
const MOST_UNDECIDED: f64 = 0.02;

fn main() {
    let arguments = Arguments::from_args();
    let all = [materials::trials(None), limits::trials(None)].concat();
    // The whole suite errs in one of a hundred runs over other seeds.
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
