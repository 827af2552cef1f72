//! All that is drawn besides materials × check, and a sixteenth of the furnace: each a test of its own.

use libtest_mimic::{Arguments, Trial};
use validate::trial::{effort, effort_of_sampling, judge};
use validate::{furnace, sampling};
use validation::Verdict;
use validation::checks::Effort;

/// Fewer than `validate sampling` and `validate furnace` take.
const SAMPLES: usize = 1 << 15;

/// Every so many cells of the furnace; coprime to the number of angles, so that all of them have their turn.
const STRIDE: usize = 16;

fn main() {
    let arguments = Arguments::from_args();
    let drawn = sampling::trials(None);
    let cells: Vec<_> = furnace::cells(None).into_iter().step_by(STRIDE).collect();
    // Both suites together err once in a hundred runs over other seeds.
    let count = drawn.len() + cells.len();
    let of_drawn = effort_of_sampling(SAMPLES, count, false);
    let of_cells = Effort { albedo: 1e-3, ..effort(SAMPLES, count, false) };
    let mut tests: Vec<Trial> = drawn
        .into_iter()
        .map(|trial| Trial::test(trial.name.clone(), move || Ok(judge(&trial, &of_drawn)?)))
        .collect();
    tests.extend(cells.into_iter().map(|cell| {
        Trial::test(cell.name.clone(), move || match cell.run(&of_cells, 0)? {
            outcome if outcome.verdict == Verdict::Different => Err(outcome.message.into()),
            _ => Ok(()),
        })
    }));
    libtest_mimic::run(&arguments, tests).exit();
}
