//! Logarithmic axes.

/// The range of an axis, in common logarithms.
#[derive(Clone, Copy)]
pub struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    /// The axis from the smallest to the largest positive finite value, slightly extended.
    pub fn over(values: impl Iterator<Item = f64>) -> Self {
        let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(libm::log10);
        let [low, high] = logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
        if low > high { Self { low: 0.0, high: 1.0 } } else { Self { low: low - 0.08, high: high + 0.08 } }
    }

    /// The position of a value on the axis, from 0 to 1; values off the axis are at the nearer end.
    pub fn share(self, value: f64) -> f64 {
        ((libm::log10(value.max(f64::MIN_POSITIVE)) - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// The integer multiples of powers of ten within the range, each with whether it is labelled: powers of
    /// ten are, and so are 2 and 5 times them where there are few powers.
    pub fn ticks(self) -> Vec<(f64, bool)> {
        let Self { low, high } = self;
        let few = high.floor() - low.ceil() < 2.0;
        let decades = low.floor() as i32..=high.floor() as i32;
        let all = decades.flat_map(|k| (1..10).map(move |m| (m, f64::from(m) * libm::exp10(f64::from(k)))));
        let within = all.filter(|(_, v)| (low..=high).contains(&libm::log10(*v)));
        within.map(|(m, v)| (v, m == 1 || few && (m == 2 || m == 5))).collect()
    }
}

/// A tick's label.
pub fn number(value: f64) -> String {
    if (1e-2..1e4).contains(&value) {
        format!("{}", libm::round(value * 100.0) / 100.0)
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_lie_within_and_some_are_named() {
        let found = Axis { low: -3.2, high: -0.9 }.ticks();
        assert!(found.iter().all(|(v, _)| (-3.2..=-0.9).contains(&libm::log10(*v))));
        let named: Vec<String> = found.iter().filter(|t| t.1).map(|t| number(t.0)).collect();
        assert_eq!(named, ["1e-3", "0.01", "0.1"]);
        assert!(Axis { low: 0.1, high: 0.5 }.ticks().iter().filter(|t| t.1).count() == 1);
    }

    #[test]
    fn what_is_not_positive_is_at_the_low_end() {
        let axis = Axis::over([1.0, 100.0, -3.0, f64::NAN, f64::INFINITY].into_iter());
        assert_eq!((axis.share(-1.0), axis.share(0.0), axis.share(1e9)), (0.0, 0.0, 1.0));
        assert!((axis.share(10.0) - 0.5).abs() < 1e-12);
    }
}
