//! A test for every scene with an analytic solution: the 99 % interval must lie within the margin.
//!
//! Intervals are several times narrower than margins, so a correct renderer fails almost never; an
//! inconclusive or different case is repeated with other seeds and four times the samples, and only a second
//! such verdict counts.

use libtest_mimic::{Arguments, Trial};
use validate::closed_forms::cases;

fn main() {
    let arguments = Arguments::from_args();
    let tests =
        cases().into_iter().map(|case| Trial::test(case.name.clone(), move || Ok(case.test()?))).collect();
    libtest_mimic::run(&arguments, tests).exit();
}
