//! The exact binomial distribution, for tails of counts so rare that neither a normal nor a Poisson
//! approximation suffices.

/// Probabilities of fewer than, exactly and more than `hits` out of `trials` at `probability` each.
///
/// The probability of `hits` is computed by Γ, its neighbours by their ratios.
fn tails(hits: u64, trials: u64, probability: f64) -> [f64; 3] {
    if hits > trials || probability.is_nan() {
        return [f64::NAN; 3];
    }
    if probability <= 0.0 || probability >= 1.0 {
        let certain = if probability >= 1.0 { trials } else { 0 };
        return [certain < hits, certain == hits, certain > hits].map(|holds| if holds { 1.0 } else { 0.0 });
    }
    let (k, n) = (hits as f64, trials as f64);
    let choices = libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0);
    let at = libm::exp(choices + k * libm::log(probability) + (n - k) * libm::log1p(-probability));
    if at == 0.0 {
        return if k < n * probability { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    }
    let odds = probability / (1.0 - probability);
    let below = series(at, |i| (k - i) / (n - k + i + 1.0) / odds);
    let above = series(at, |i| (n - k - i) / (k + i + 1.0) * odds);
    [below.min(1.0), at.min(1.0), above.min(1.0)]
}

/// Sum of the terms after `first`, each the previous one times `ratio`, until they are negligible.
fn series(first: f64, ratio: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut term, mut i) = (0.0, first, 0.0);
    loop {
        let ratio = ratio(i);
        term *= ratio;
        // Ratios decrease monotonically, so once they are below 1 the series converges.
        if term <= 0.0 || (ratio < 1.0 && term < f64::EPSILON * 1e-3 * sum) {
            return sum;
        }
        sum += term;
        i += 1.0;
    }
}

/// Two-sided p-value of `hits` out of `trials` when each trial hits with probability `probability`: twice the
/// smaller tail, including the observed count. NaN stays NaN.
pub fn binomial_two_sided(hits: u64, trials: u64, probability: f64) -> f64 {
    let [below, at, above] = tails(hits, trials, probability);
    let tail = if below < above { below } else { above };
    if (tail + at).is_nan() { f64::NAN } else { (2.0 * (tail + at)).min(1.0) }
}

/// The randomised p-value, which is uniform: the observed count is included in the tail with the weight `u`,
/// uniform on \[0, 1). Without randomisation p-values of a discrete test are larger than uniform ones, and a
/// ledger of them would fail.
pub fn binomial_randomised(hits: u64, trials: u64, probability: f64, u: f64) -> f64 {
    let [below, at, above] = tails(hits, trials, probability);
    let [low, high] = [below + u * at, above + (1.0 - u) * at];
    let tail = if low < high { low } else { high };
    if tail.is_nan() { f64::NAN } else { (2.0 * tail).min(1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Stream, distributions::normal_two_sided, uniformity};

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected}");
    }

    #[test]
    fn tails_agree_with_exact_sums() {
        // P(X = 0) = 0.999^3000 of Bin(3000, 0.001); two-sided doubles it.
        close(binomial_two_sided(0, 3000, 0.001), 2.0 * libm::exp(3000.0 * libm::log(0.999)), 1e-9);
        // Bin(4, 1/2): P(X ≥ 4) = 1/16; and the whole distribution is 1.
        close(binomial_two_sided(4, 4, 0.5), 0.125, 1e-12);
        assert_eq!(binomial_two_sided(2, 4, 0.5), 1.0);
        for (hits, trials, probability) in
            [(0, 10, 0.3), (7, 10, 0.3), (1310, 131_072, 0.01), (65_000, 131_072, 0.5)]
        {
            close(tails(hits, trials, probability).iter().sum(), 1.0, 1e-9);
        }
        assert_eq!(binomial_two_sided(10, 10, 1.0), 1.0);
        assert_eq!(binomial_two_sided(9, 10, 1.0), 0.0);
        // With a continuity correction of half a hit, at a standard deviation of 50 hits.
        close(binomial_two_sided(5100, 10_000, 0.5), normal_two_sided(1.99), 2e-3);
        assert!(
            binomial_two_sided(1, 10, f64::NAN).is_nan()
                && binomial_randomised(1, 10, f64::NAN, 0.5).is_nan()
        );
    }

    #[test]
    fn randomised_p_values_are_uniform_however_rare_the_hits() {
        let mut stream = Stream::named("binomial", 0);
        for (trials, probability) in [(200, 0.002), (200, 0.3), (500, 0.995)] {
            let p_values: Vec<f64> = (0..2000)
                .map(|_| {
                    let hits = (0..trials).filter(|_| stream.uniform() < probability).count() as u64;
                    binomial_randomised(hits, trials, probability, stream.uniform())
                })
                .collect();
            assert!(uniformity(&p_values) > 1e-3, "{trials} {probability}: {}", uniformity(&p_values));
        }
    }
}
