//! Roots of functions of one variable.

/// A zero of a function between two places where its values have different signs; `None` if they have not, or
/// if 64 steps do not find it. It is found to within `error` of zero, or to the last digit.
///
/// False position, where the value at an end that stays is halved each time (the Illinois method). Six or
/// seven steps are usual; bisection would need as many as there are bits.
#[inline]
pub fn between(
    mut low: (f64, f64),
    mut high: (f64, f64),
    error: f64,
    mut value: impl FnMut(f64) -> f64,
) -> Option<f64> {
    const STEPS: usize = 64;
    let rises = low.1 < 0.0;
    if (high.1 < 0.0) == rises || low.1.is_nan() || high.1.is_nan() {
        return None;
    }
    // Which end was replaced last.
    let mut last = None;
    for _ in 0..STEPS {
        let t = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let found = value(t);
        // The ends are adjacent numbers if no other one lies between them.
        if found.abs() <= error || t <= low.0 || t >= high.0 {
            return Some(t);
        }
        let is_low = (found < 0.0) == rises;
        let again = last == Some(is_low);
        let (end, stays) = if is_low { (&mut low, &mut high) } else { (&mut high, &mut low) };
        *end = (t, found);
        if again {
            stays.1 *= 0.5;
        }
        last = Some(is_low);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::between;

    #[test]
    fn zeros_are_found_between_signs() {
        let cubic = |t: f64| t * t * t - 2.0;
        let ends = |low: f64, high: f64| ((low, cubic(low)), (high, cubic(high)));
        let (low, high) = ends(0.0, 3.0);
        let found = between(low, high, 0.0, cubic).unwrap();
        assert!((found * found * found - 2.0).abs() < 1e-14, "{found}");
        let falling = between((0.0, 2.0), (3.0, -25.0), 0.0, |t| -cubic(t)).unwrap();
        assert_eq!(falling, found);
        let (low, high) = ends(2.0, 3.0);
        assert_eq!(between(low, high, 0.0, cubic), None);
        assert_eq!(between((0.0, f64::NAN), (3.0, 1.0), 0.0, cubic), None);
    }

    #[test]
    fn a_steep_end_takes_few_steps() {
        let mut steps = 0;
        let value = |t: f64| {
            steps += 1;
            1e-3 - (1.0 - t * t).sqrt()
        };
        let found = between((0.0, 1e-3 - 1.0), (1.0, 1e-3), 1e-15, value).unwrap();
        assert!((found - (1.0f64 - 1e-6).sqrt()).abs() < 1e-12, "{found}");
        assert!(steps < 40, "{steps}");
    }
}
