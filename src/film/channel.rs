//! Mean and variance of one channel of one pixel.

use super::ExactSum;

/// Number of consecutive samples that are summed plainly before they enter the exact sums. Sample ranges
/// begin at a multiple of it.
pub const BLOCK: u64 = 4;

/// The samples of one channel of one pixel: Σ s_b and Σ s_b² over the complete blocks b, where s_b is the sum
/// of the [`BLOCK`] samples of a block; and the sum of the samples after the last complete block.
///
/// Accumulators of disjoint sample ranges merge, in any order, to the same bits as one run over their union.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelAccumulator {
    pub(super) sum: ExactSum,
    pub(super) squares: ExactSum,
    pub(super) open: f64,
}

impl ChannelAccumulator {
    /// Adds the sample with the given index (counted over the whole render). The samples of a range come in
    /// increasing order, and the range begins at a multiple of [`BLOCK`].
    #[inline]
    pub fn add(&mut self, index: u64, value: f64) {
        self.open += value;
        if index % BLOCK == BLOCK - 1 {
            self.sum.add(self.open);
            self.squares.add_square(self.open);
            self.open = 0.0;
        }
    }

    /// Adds the samples of another, disjoint range. At most one of the two may have an incomplete last block.
    pub fn merge(&mut self, other: &ChannelAccumulator) {
        self.sum.merge(&other.sum);
        self.squares.merge(&other.squares);
        self.open += other.open;
    }

    /// Adds the sum of all samples in complete blocks to another.
    #[inline]
    pub fn add_blocks_to(&self, sum: &mut ExactSum) {
        sum.merge(&self.sum);
    }

    /// The mean of all `samples` samples; NaN if one of them was not finite, or if there are none.
    pub fn mean(&self, samples: u64) -> f64 {
        let mut sum = self.sum;
        sum.add(self.open);
        sum.value() / samples as f64
    }

    /// An estimate of the variance of [`mean`](Self::mean), from the scatter of the block sums.
    ///
    /// With B complete blocks, V = (Σ s_b² − (Σ s_b)² / B) / (B − 1) estimates the variance of one block sum
    /// without bias if blocks are independent. A sum of n samples is n / BLOCK blocks, so its variance is n V
    /// / BLOCK, and that of the mean V / (BLOCK n). For n = BLOCK · B this is the familiar V B / n². The
    /// samples of an incomplete last block count in n but not in V. Within a block samples may be correlated,
    /// as those of a stratified sequence are; between blocks such a sequence is correlated negatively, which
    /// makes this estimate err on the large side.
    ///
    /// Rounding can make the difference negative; it is clamped at zero. Fewer than two complete blocks, or
    /// squares outside the range of f64, give +∞, "unknown". NaN if a sample was not finite.
    pub fn variance(&self, samples: u64) -> f64 {
        let blocks = (samples / BLOCK) as f64;
        if !self.sum.is_finite() || !self.open.is_finite() {
            return f64::NAN;
        }
        if blocks < 2.0 || !self.squares.is_finite() {
            return f64::INFINITY;
        }
        let sum = self.sum.value();
        let scatter = (self.squares.value() - sum * (sum / blocks)).max(0.0);
        scatter / (blocks - 1.0) / (BLOCK as f64 * samples as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn accumulate(first: u64, values: &[f64]) -> ChannelAccumulator {
        let mut channel = ChannelAccumulator::default();
        (first..).zip(values).for_each(|(index, &value)| channel.add(index, value));
        channel
    }

    fn sample() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), 0.0..1.0, -1e-9..1e-9, 0.0..1e7, 1e-30..1e-20]
    }

    proptest! {
        #[test]
        fn ranges_merge_to_one_run(
            values in prop::collection::vec(sample(), 0..50),
            cut in any::<prop::sample::Index>(),
        ) {
            let cut = cut.index(values.len() / BLOCK as usize + 1) * BLOCK as usize;
            let whole = accumulate(0, &values);
            let (mut a, mut b) = (accumulate(0, &values[..cut]), accumulate(cut as u64, &values[cut..]));
            let before = a;
            a.merge(&b);
            b.merge(&before);
            prop_assert_eq!(a, whole);
            prop_assert_eq!(b, whole);
        }

        #[test]
        fn agrees_with_the_textbook(values in prop::collection::vec(-1.0..1.0, 8..50)) {
            let n = values.len() as f64;
            let channel = accumulate(0, &values);
            let mean = values.iter().sum::<f64>() / n;
            // 50 additions of values below 1, each off by at most half an ulp of 50.
            prop_assert!((channel.mean(values.len() as u64) - mean).abs() <= 50.0 * libm::scalbn(1.0, -48));
            let blocks: Vec<f64> = values.chunks_exact(4).map(|block| block.iter().sum()).collect();
            let block_mean = blocks.iter().sum::<f64>() / blocks.len() as f64;
            let scatter = blocks.iter().map(|sum| (sum - block_mean) * (sum - block_mean)).sum::<f64>();
            let variance = scatter / (blocks.len() as f64 - 1.0) / 4.0 / n;
            prop_assert!((channel.variance(values.len() as u64) - variance).abs() <= 50.0 * libm::scalbn(1.0, -48));
        }

        #[test]
        fn brighter_lights_scale_mean_and_variance_exactly(
            values in prop::collection::vec(1e-6..1e6, 8..50),
            shift in -100i32..100,
        ) {
            let n = values.len() as u64;
            let scaled: Vec<f64> = values.iter().map(|&value| libm::scalbn(value, shift)).collect();
            let (one, other) = (accumulate(0, &values), accumulate(0, &scaled));
            prop_assert_eq!(other.mean(n), libm::scalbn(one.mean(n), shift));
            prop_assert_eq!(other.variance(n), libm::scalbn(one.variance(n), 2 * shift));
        }
    }

    #[test]
    fn variance_is_unknown_below_two_blocks() {
        assert_eq!(accumulate(0, &[1.0; 7]).variance(7), f64::INFINITY);
        assert_eq!(accumulate(0, &[1.0; 8]).variance(8), 0.0);
        assert_eq!(accumulate(0, &[1e200; 8]).variance(8), f64::INFINITY);
        assert_eq!(accumulate(0, &[1e200; 8]).mean(8), 1e200);
    }

    #[test]
    fn non_finite_samples_show() {
        for bad in [f64::NAN, f64::INFINITY] {
            for position in [0, 9] {
                let mut values = [1.0; 10];
                values[position] = bad;
                assert!(accumulate(0, &values).mean(10).is_nan());
                assert!(accumulate(0, &values).variance(10).is_nan());
            }
        }
    }
}
