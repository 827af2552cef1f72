//! Choosing one of n with given probabilities.

/// A discrete distribution over indices, sampled by bisection of its running sum.
#[derive(Clone, Debug, Default)]
pub struct Discrete {
    /// Running sums of the weights, normalised; the last is 1.
    cumulative: Vec<f64>,
    /// The sum of the weights before normalisation.
    total: f64,
}

impl Discrete {
    /// From weights that are finite and not negative. If all are zero, every index is equally likely.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut total = 0.0;
        let mut cumulative: Vec<f64> = weights
            .into_iter()
            .map(|w| {
                total += w;
                total
            })
            .collect();
        let n = cumulative.len();
        for (i, c) in cumulative.iter_mut().enumerate() {
            *c = if total > 0.0 { *c / total } else { (i + 1) as f64 / n as f64 };
        }
        // Rounding must not leave a sliver above the last entry that has any weight.
        let end = cumulative.last().copied().unwrap_or(1.0);
        for c in cumulative.iter_mut().rev().take_while(|c| **c == end) {
            *c = 1.0;
        }
        Self { cumulative, total }
    }

    /// How many indices there are.
    pub fn len(&self) -> usize {
        self.cumulative.len()
    }

    /// Whether there is nothing to choose.
    pub fn is_empty(&self) -> bool {
        self.cumulative.is_empty()
    }

    /// The sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The probability of index `i`.
    #[inline]
    pub fn probability(&self, i: usize) -> f64 {
        self.cumulative[i] - if i == 0 { 0.0 } else { self.cumulative[i - 1] }
    }

    /// The index that u in [0, 1) falls on, its probability, and u rescaled to [0, 1) within it for reuse.
    #[inline]
    pub fn sample(&self, u: f64) -> (usize, f64, f64) {
        let i = self.cumulative.partition_point(|&c| c <= u).min(self.cumulative.len() - 1);
        let below = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let probability = self.cumulative[i] - below;
        (i, probability, ((u - below) / probability).min(1.0 - f64::EPSILON / 2.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_without_weight_are_never_chosen() {
        let d = Discrete::new([0.0, 1.0, 0.0, 3.0, 0.0]);
        let mut counts = [0; 5];
        for i in 0..1000 {
            let (index, probability, rest) = d.sample((i as f64 + 0.5) / 1000.0);
            counts[index] += 1;
            assert_eq!(probability, d.probability(index));
            assert!((0.0..1.0).contains(&rest));
        }
        assert_eq!(counts, [0, 250, 0, 750, 0]);
        assert_eq!(d.sample(0.0).0, 1);
        assert_eq!(d.sample(1.0 - f64::EPSILON / 2.0).0, 3);
    }

    #[test]
    fn no_weight_at_all_is_uniform() {
        assert_eq!(Discrete::new([0.0, 0.0]).probability(1), 0.5);
    }
}
