//! Corrections for many tests, so that all together keep the stated level.

/// Level of each of `count` tests so that, independent or positively dependent, at least one rejects with
/// probability at most `level` (Šidák 1967): 1 − (1 − α)^(1/n).
pub fn sidak(level: f64, count: usize) -> f64 {
    -libm::expm1(libm::log1p(-level) / count.max(1) as f64)
}

/// The p-value of the smallest of `count` p-values: 1 − (1 − p)^n, the inverse of [`sidak`].
pub fn smallest_of(p_value: f64, count: usize) -> f64 {
    if p_value >= 1.0 { 1.0 } else { -libm::expm1(libm::log1p(-p_value) * count.max(1) as f64) }
}

/// Indices of `p_values` in ascending order; NaN first, since a failed test must not look insignificant.
fn ascending(p_values: &[f64]) -> Vec<usize> {
    let key = |index: usize| if p_values[index].is_nan() { -1.0 } else { p_values[index] };
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&i, &j| key(i).total_cmp(&key(j)));
    order
}

/// Indices rejected by Holm's step-down procedure (Holm 1979): family-wise error at most `level` under any
/// dependence.
pub fn holm(p_values: &[f64], level: f64) -> Vec<usize> {
    let order = ascending(p_values);
    let count = order.len();
    let kept = order.iter().enumerate().position(|(rank, &i)| p_values[i] > level / (count - rank) as f64);
    order[..kept.unwrap_or(count)].to_vec()
}

/// Indices rejected by Benjamini and Hochberg's step-up procedure (1995): false discovery rate at most
/// `rate`.
pub fn benjamini_hochberg(p_values: &[f64], rate: f64) -> Vec<usize> {
    let order = ascending(p_values);
    let count = order.len() as f64;
    let last = order.iter().enumerate().rposition(|(rank, &i)| {
        let limit = rate * (rank + 1) as f64 / count;
        p_values[i].is_nan() || p_values[i] <= limit
    });
    order[..last.map_or(0, |rank| rank + 1)].to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sidak_and_its_inverse() {
        assert!((sidak(0.05, 2) - 0.025320565519103666).abs() < 1e-15);
        for count in [1, 7, 100_000] {
            assert!((smallest_of(sidak(0.01, count), count) - 0.01).abs() < 1e-12);
        }
    }

    #[test]
    fn step_procedures_follow_their_definition() {
        let p_values = [0.01, 0.04, 0.03, 0.005];
        // Holm: 0.005 ≤ 0.05/4, 0.01 ≤ 0.05/3, 0.03 > 0.05/2.
        assert_eq!(holm(&p_values, 0.05), [3, 0]);
        // Benjamini–Hochberg: the largest, 0.04 ≤ 0.05·4/4, rejects all.
        assert_eq!(benjamini_hochberg(&p_values, 0.05), [3, 0, 2, 1]);
        assert!(holm(&[0.5, 0.9], 0.05).is_empty() && benjamini_hochberg(&[0.5, 0.9], 0.05).is_empty());
    }

    #[test]
    fn a_broken_test_is_rejected_first() {
        assert_eq!(holm(&[0.5, f64::NAN], 0.05), [1]);
        assert_eq!(benjamini_hochberg(&[0.5, f64::NAN], 0.05), [1]);
    }
}
