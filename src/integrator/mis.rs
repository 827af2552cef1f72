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
pub fn power_heuristic_of_three(b_over_a: f64, c_over_a: f64) -> f64 {
    1.0 / (1.0 + b_over_a * b_over_a + c_over_a * c_over_a)
}

#[cfg(test)]
mod tests {
    use super::power_heuristic;

    #[test]
    fn weights_sum_to_one_at_any_scale() {
        for (a, b) in [(1.0, 3.0), (1e200, 3e200), (1e-300, 1e300), (0.0, 1.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-15, "{a} {b}");
        }
    }
}
