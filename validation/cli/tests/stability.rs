//! A test for every stiff or extreme case: its expectation holds, or is missed within its known limit.
//!
//! An inconclusive or different case is repeated with other seeds and four times the samples, and only a
//! second such verdict counts.

use libtest_mimic::{Arguments, Trial};
use validate::stability::cases;

fn main() {
    let arguments = Arguments::from_args();
    let tests =
        cases().into_iter().map(|case| Trial::test(case.name.clone(), move || Ok(case.test()?))).collect();
    libtest_mimic::run(&arguments, tests).exit();
}
