//! Every stiff or extreme case, each a test of its own: its expectation holds, or is missed within its known
//! limit.
//!
//! What is undecided or different is repeated with other seeds and four times the samples, and only a second
//! such answer counts.

use libtest_mimic::{Arguments, Trial};
use validate::stability::cases;

fn main() {
    let arguments = Arguments::from_args();
    let tests =
        cases().into_iter().map(|case| Trial::test(case.name.clone(), move || Ok(case.test()?))).collect();
    libtest_mimic::run(&arguments, tests).exit();
}
