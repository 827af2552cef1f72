//! Weights of multiple importance sampling.

/// The power heuristic with exponent 2 (Veach 1997, §9.2.4), as 1/(1 + (b/a)²): densities are never squared
/// alone, so none can overflow.
#[inline]
pub fn power_heuristic(a: f64, b: f64) -> f64 {
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}

/// The power heuristic of three techniques, from the densities of the other two over that of this one.
#[inline]
pub fn power_heuristic_of_ratios(b_over_a: f64, c_over_a: f64) -> f64 {
    1.0 / (1.0 + b_over_a * b_over_a + c_over_a * c_over_a)
}

#[cfg(test)]
mod tests {
    use super::{power_heuristic, power_heuristic_of_ratios};

    #[test]
    fn weights_sum_to_one_at_any_scale() {
        for (a, b) in [(1.0, 3.0), (1e200, 3e200), (1e-300, 1e300), (0.0, 1.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-15, "{a} {b}");
        }
        for [a, b, c] in [[1.0, 3.0, 2.0], [1e200, 3e200, 0.0], [1e-300, 1e300, 1e-300], [0.0, 0.0, 1.0]] {
            let of = |own: f64, one: f64, other: f64| match own {
                // Such a sample is never drawn.
                0.0 => 0.0,
                _ => power_heuristic_of_ratios(one / own, other / own),
            };
            let sum = of(a, b, c) + of(b, c, a) + of(c, a, b);
            assert!((sum - 1.0).abs() < 1e-15, "{a} {b} {c}: {sum}");
            assert!((of(a, b, 0.0) - power_heuristic(a, b)).abs() < 1e-15 || a == 0.0, "{a} {b}");
        }
    }

    #[test]
    fn what_another_technique_always_finds_is_left_to_it() {
        assert_eq!(power_heuristic_of_ratios(f64::INFINITY, 1.0), 0.0);
        assert_eq!(power_heuristic_of_ratios(0.0, 0.0), 1.0);
        // Densities as 1, 2 and 2: weights as 1, 4 and 4.
        assert_eq!(power_heuristic_of_ratios(2.0, 2.0), 1.0 / 9.0);
    }
}
