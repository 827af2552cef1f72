//! Random choices that are a function of a name and a number.

use validation::statistics::Stream;

/// A stream of random choices.
pub struct Draw(Stream);

impl Draw {
    /// The stream of seed [`validation::statistics::seed_for`]`(name, number)`.
    pub fn named(name: &str, number: u64) -> Self {
        Self(Stream::named(name, number))
    }

    /// Uniform on \[`low`, `high`).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.0.uniform() < probability
    }

    /// Uniform among 0..count; 0 if there is nothing to choose from.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.0.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// One of a slice that is not empty.
    pub fn of<'a, T>(&mut self, choices: &'a [T]) -> &'a T {
        &choices[self.below(choices.len())]
    }

    /// 1 + ⌊`most` · 2⁻ˣ⌋ with x uniform on \[0, 10): log-uniform, so that most numbers are small and numbers
    /// up to `most` occur.
    pub fn few(&mut self, most: usize) -> usize {
        let scale = libm::exp2(-self.between(0.0, 10.0));
        1 + (scale * most as f64) as usize
    }

    pub fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_stay_within_their_bounds() {
        let mut draw = Draw::named("bounds", 0);
        for _ in 0..10_000 {
            assert!((2.0..3.0).contains(&draw.between(2.0, 3.0)));
            assert!(draw.below(7) < 7 && draw.below(1) == 0 && draw.below(0) == 0);
            assert!((1..=101).contains(&draw.few(100)));
        }
        assert!(!draw.chance(0.0) && draw.chance(1.0));
    }
}
