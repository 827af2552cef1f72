//! A test for every relation between renders: bit-identical, or equivalent within the margin.
//!
//! A statistical relation that is inconclusive or different is repeated with other seeds and four times the
//! samples, and only a second such verdict counts. Those that take long are ignored by default: `cargo test
//! --release -p validate --test metamorphic -- --ignored` runs them.

use libtest_mimic::{Arguments, Trial};
use validate::metamorphic::relations;

fn main() {
    let arguments = Arguments::from_args();
    let tests = relations()
        .into_iter()
        .map(|relation| {
            let at_length = relation.at_length;
            Trial::test(relation.name.clone(), move || Ok(relation.test()?)).with_ignored_flag(at_length)
        })
        .collect();
    libtest_mimic::run(&arguments, tests).exit();
}
