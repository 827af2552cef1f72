//! The uniformity of p-values, which tests the checks themselves.

/// p-value of Kolmogorov and Smirnov's test of `values` against the uniform distribution on \[0, 1\].
///
/// The asymptotic series Q(λ) = 2 Σ (−1)^(k−1) exp(−2k²λ²) with λ = (√n + 0.12 + 0.11/√n) D (Stephens 1970).
/// A value that is NaN or outside \[0, 1\] gives 0.
pub fn uniformity(values: &[f64]) -> f64 {
    if values.iter().any(|value| !(0.0..=1.0).contains(value)) {
        return 0.0;
    }
    if values.is_empty() {
        return 1.0;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let distance = sorted.iter().enumerate().fold(0.0f64, |distance, (rank, value)| {
        distance.max(value - rank as f64 / count).max((rank + 1) as f64 / count - value)
    });
    let root = count.sqrt();
    kolmogorov_upper((root + 0.12 + 0.11 / root) * distance)
}

fn kolmogorov_upper(lambda: f64) -> f64 {
    // The alternating series converges slowly there, and the probability is 1 to ten digits.
    if lambda < 0.2 {
        return 1.0;
    }
    let term = |k: f64| libm::exp(-2.0 * k * k * lambda * lambda);
    let sum: f64 = (1..=20).map(f64::from).map(|k| if k % 2.0 == 1.0 { term(k) } else { -term(k) }).sum();
    (2.0 * sum).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Stream;

    #[test]
    fn matches_the_critical_value() {
        // The classical asymptotic 5 % point.
        assert!((kolmogorov_upper(1.3581) - 0.05).abs() < 1e-4);
    }

    #[test]
    fn sees_a_slight_bend_and_accepts_the_uniform() {
        let mut stream = Stream::named("uniformity", 0);
        let uniform: Vec<f64> = (0..10_000).map(|_| stream.uniform()).collect();
        assert!(uniformity(&uniform) > 1e-3);
        let bent: Vec<f64> = uniform.iter().map(|u| libm::pow(*u, 1.1)).collect();
        assert!(uniformity(&bent) < 1e-3);
        assert_eq!(uniformity(&[0.5, f64::NAN]), 0.0);
    }
}
