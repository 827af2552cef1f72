//! Choosing one of n with given probabilities.

use super::{BELOW_ONE, DVec2};

/// What a random number has chosen of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen<Rest = f64> {
    pub index: usize,
    /// Of choosing this index.
    pub probability: f64,
    /// The number, or the numbers, rescaled to [0, 1) within the choice for reuse.
    pub rest: Rest,
}

/// A discrete distribution over indices, sampled by search in its running sum.
#[derive(Clone, Debug, Default)]
pub struct Discrete {
    /// Running sums of the weights, normalised; the last is 1.
    cumulative: Vec<f64>,
    /// Where to begin: for u in [k/n, (k + 1)/n) the first index whose running sum is above k/n (Chen and
    /// Asau 1974). The search from there takes two steps on average, however uneven the weights.
    guide: Vec<u32>,
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
        let mut index = 0;
        let guide = (0..n).map(|k| {
            while index + 1 < n && cumulative[index] <= k as f64 / n as f64 {
                index += 1;
            }
            index as u32
        });
        Self { guide: guide.collect(), cumulative, total }
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

    /// The index that u in [0, 1) falls on.
    #[inline]
    pub fn sample(&self, u: f64) -> Chosen {
        let last = self.cumulative.len() - 1;
        let mut i = self.guide[((u * self.cumulative.len() as f64) as usize).min(last)] as usize;
        // k/n may have been rounded to above u.
        while i > 0 && self.cumulative[i - 1] > u {
            i -= 1;
        }
        while i < last && self.cumulative[i] <= u {
            i += 1;
        }
        let below = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let probability = self.cumulative[i] - below;
        Chosen { index: i, probability, rest: ((u - below) / probability).min(BELOW_ONE) }
    }

    /// The index that the first of two numbers in [0, 1) falls on; both are left for reuse.
    ///
    /// Each index gets a strip of the unit square, over which points that are stratified over the square are
    /// stratified as well. If another number made the choice, each index would get an arbitrary subset of
    /// them. The choice uses up bits of the first number; `digits`, in [0, 1), adds 32 bits to it.
    #[inline]
    pub fn sample_strip(&self, u: DVec2, digits: f64) -> Chosen<DVec2> {
        let Chosen { index, probability, rest } = self.sample(with_digits(u.x, digits));
        Chosen { index, probability, rest: DVec2::new(rest, u.y) }
    }
}

/// A number of 32 bits in [0, 1) with those of another behind its own, as far as there is room.
#[inline]
pub fn with_digits(u: f64, digits: f64) -> f64 {
    (u + digits * (1.0 / 4294967296.0)).min(BELOW_ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_falls_to_each_index_and_is_spread_over_the_square_again() {
        let d = Discrete::new([1.0, 0.0, 3.0]);
        let n = 64;
        let points = (0..n * n).map(|i| (f64::from(i % n) / f64::from(n), f64::from(i / n) / f64::from(n)));
        let mut counts = [[[0; 2]; 2]; 3];
        for (x, y) in points {
            let Chosen { index, probability, rest } = d.sample_strip(DVec2::new(x, y), 0.5);
            assert!(probability == d.probability(index) && rest.y == y);
            counts[index][usize::from(rest.x >= 0.5)][usize::from(y >= 0.5)] += 1;
        }
        assert_eq!(counts, [[[256; 2]; 2], [[0; 2]; 2], [[768; 2]; 2]]);
    }

    #[test]
    fn digits_fill_what_a_choice_takes() {
        let word = 1.0 / 4294967296.0;
        assert_eq!(with_digits(0.5, 0.25), 0.5 + 0.25 * word);
        assert_eq!(with_digits(1.0 - word, 1.0 - word), BELOW_ONE);
        // A hundred thousand emitters leave 15 bits of 32, and all of these.
        let d = Discrete::new(std::iter::repeat_n(1.0, 100_000));
        let rest = |digits: f64| d.sample_strip(DVec2::new(0.3, 0.0), digits).rest.x;
        assert!((rest(0.5) - rest(0.0) - 0.5 * word * 1e5).abs() < 1e-6 * word * 1e5, "{}", rest(0.5));
    }

    #[test]
    fn the_guide_leads_to_where_bisection_does() {
        let weights = [0.0, 1e-9, 5.0, 0.0, 0.0, 1e-3, 0.3, 0.0];
        let d = Discrete::new(weights.iter().cycle().copied().take(37));
        let mut probes: Vec<f64> = (0..4096).map(|i| f64::from(i) / 4096.0).collect();
        probes.extend(d.cumulative.iter().flat_map(|c| [c.next_down(), *c]).filter(|u| *u < 1.0));
        probes.extend((0..37).map(|k| f64::from(k) / 37.0));
        for u in probes {
            let bisected = d.cumulative.partition_point(|&c| c <= u).min(d.len() - 1);
            assert_eq!(d.sample(u).index, bisected, "{u}");
        }
    }

    #[test]
    fn indices_without_weight_are_never_chosen() {
        let d = Discrete::new([0.0, 1.0, 0.0, 3.0, 0.0]);
        let mut counts = [0; 5];
        for i in 0..1000 {
            let Chosen { index, probability, rest } = d.sample((i as f64 + 0.5) / 1000.0);
            counts[index] += 1;
            assert_eq!(probability, d.probability(index));
            assert!((0.0..1.0).contains(&rest));
        }
        assert_eq!(counts, [0, 250, 0, 750, 0]);
        assert_eq!(d.sample(0.0).index, 1);
        assert_eq!(d.sample(BELOW_ONE).index, 3);
    }

    #[test]
    fn no_weight_at_all_is_uniform() {
        assert_eq!(Discrete::new([0.0, 0.0]).probability(1), 0.5);
    }
}
