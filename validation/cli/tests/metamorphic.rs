//! Every relation between renders, each a test of its own: bit-identical, or equivalent within the margin.
//!
//! A statistical relation that is undecided or different is repeated with other seeds and four times the
//! samples, and only a second such answer counts. Those at length are ignored unless asked for: `cargo test
//! --release -p validate --test metamorphic -- --ignored`.

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
