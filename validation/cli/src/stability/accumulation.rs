//! Sums over very many samples.

use super::Case;
use etalon::film::{BLOCK, ChannelAccumulator};

/// Number of samples of a test run; 10⁹ with `--thorough`.
const SAMPLES: u64 = 100_000_000;

pub fn cases() -> Vec<Case> {
    vec![
        Case::at_most(
            "mean_of_very_many",
            "10⁸ samples (10⁹ with --thorough) of 0.1 as f32: the mean keeps a relative error of 10⁻⁷",
            1e-7,
            Box::new(|effort| Ok(constant(effort.min(super::THOROUGH) * SAMPLES))),
        ),
        Case::at_most(
            "small_beside_large",
            "10⁶ samples of 1 after one of 2⁴⁰, then −2⁴⁰: the mean is that of the ones, exactly",
            0.0,
            Box::new(|_| Ok(beside_large())),
        ),
        Case::at_most(
            "order_of_ranges",
            "ranges of samples over 60 orders of magnitude, merged in seven orders: bits of mean and variance that differ",
            0.0,
            Box::new(|_| Ok(orders())),
        ),
    ]
}

fn constant(samples: u64) -> f64 {
    let value = f64::from(0.1f32);
    let mut sum = ChannelAccumulator::default();
    (0..samples).for_each(|i| sum.add(i, value));
    (sum.mean(samples) / value - 1.0).abs()
}

fn beside_large() -> f64 {
    const ONES: u64 = 1_000_000;
    let large = libm::exp2(40.0);
    let mut sum = ChannelAccumulator::default();
    // Each gets a block of its own, since the plain sum within a block would round.
    let large_blocks = [large, 0.0, 0.0, 0.0].into_iter();
    let values = large_blocks.chain((0..ONES).map(|_| 1.0)).chain([-large, 0.0, 0.0, 0.0]);
    let mut count = 0;
    for value in values {
        sum.add(count, value);
        count += 1;
    }
    (sum.mean(count) / (ONES as f64 / count as f64) - 1.0).abs()
}

fn orders() -> f64 {
    const RANGES: u64 = 97;
    const LENGTH: u64 = 4 * BLOCK;
    let value = |i: u64| {
        let draw = validation::statistics::seed_for("order", i);
        let magnitude = libm::exp10((draw % 61) as f64 - 30.0);
        magnitude * (draw >> 11) as f64 / (1u64 << 53) as f64
    };
    let range = |k: u64| {
        let mut part = ChannelAccumulator::default();
        (k * LENGTH..(k + 1) * LENGTH).for_each(|i| part.add(i, value(i)));
        part
    };
    // Multiples of a number coprime to 97 visit every range once.
    let merged = [1, 2, 5, 31, 60, 95, 96].map(|step| {
        let mut sum = ChannelAccumulator::default();
        (0..RANGES).for_each(|k| sum.merge(&range(k * step % RANGES)));
        [sum.mean(RANGES * LENGTH), sum.variance(RANGES * LENGTH)].map(f64::to_bits)
    });
    merged.iter().filter(|bits| **bits != merged[0]).count() as f64
}
