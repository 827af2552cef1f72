//! Every material × example × check × direction, each a test of its own.

use libtest_mimic::{Arguments, Trial};
use validate::trial::{effort, judge};
use validate::{limits, materials};

/// Enough to see a few per cent of wrong density in any lobe; `validate bsdf --samples` asks for more.
const SAMPLES: usize = 1 << 17;

fn main() {
    let arguments = Arguments::from_args();
    let all = [materials::trials(None), limits::trials(None)].concat();
    // The whole suite errs once in a hundred runs over other seeds.
    let effort = effort(SAMPLES, all.len(), false);
    let tests =
        all.into_iter().map(|trial| Trial::test(trial.name.clone(), move || Ok(judge(&trial, &effort)?)));
    libtest_mimic::run(&arguments, tests.collect()).exit();
}
