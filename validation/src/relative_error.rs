//! What relative squared errors of pictures mean here, wherever they are reported.

/// Share of the largest squared errors that the trimmed mean leaves out, as is common to keep fireflies from
/// dominating.
const TRIM: f64 = 0.001;

/// Part of the reference's mean that is added in quadrature to its values in denominators. Usual definitions add
/// an absolute 0.01, which makes the metric depend on the unit of radiance; this one does not.
pub const SOFTENING: f64 = 0.01;

/// The mean without the 0.1 % of the values that are largest, rounded up; NaN of no values, and of one that value.
pub fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let left_out = (TRIM * values.len() as f64).ceil() as usize;
    let kept = (values.len() - left_out).max(usize::from(!values.is_empty()));
    values[..kept].iter().sum::<f64>() / kept as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_are_left_out_but_never_all() {
        assert_eq!(trimmed_mean(vec![3.0]), 3.0);
        assert_eq!(trimmed_mean(vec![7.0, 1.0]), 1.0);
        let firefly = |count: usize| (0..count).map(|i| if i == 5 { 1e6 } else { 1.0 }).collect();
        assert_eq!(trimmed_mean(firefly(1000)), 1.0);
        assert_eq!(trimmed_mean(firefly(2000)), 1.0);
        assert!(trimmed_mean(vec![]).is_nan());
    }
}
