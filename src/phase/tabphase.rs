//! A measured or computed phase function: p(cos θ) linear between values at evenly spaced cosines, as Mitsuba's
//! `tabphase` has it.

use super::Phase;
use crate::math::{DVec3, INV_PI};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::transform::numbers;
use std::sync::Arc;

/// Scattering by a table.
#[derive(Clone, Debug)]
pub struct Tabulated {
    /// From straight on to straight back.
    knots: Arc<[Knot]>,
}

#[derive(Clone, Copy, Debug)]
struct Knot {
    /// In sr⁻¹.
    density: f64,
    /// The share of light that is turned less.
    before: f64,
}

impl Phase for Tabulated {
    const NAME: &'static str = "tabphase";
    const ABOUT: &'static str = "A phase function linear between values at evenly spaced cosines.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<phase type="tabphase"><string name="values" value="1, 1"/></phase>"#,
        r#"<phase type="tabphase"><string name="values" value="0, 3"/></phase>"#,
        r#"<phase type="tabphase"><string name="values" value="0.5, 0.2, 0.1, 0.02, 0.01, 0.3, 2, 10"/></phase>"#,
    ];

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about = "densities up to a factor, from cos θ = −1, straight back, to 1, straight on";
        let Some(text) = params.string("values", about)? else {
            return Err(SceneError::at(&params.element.span, "there are no `values`", "add at least two"));
        };
        let values = numbers(text)?;
        let refused = |message: String, expected: &str| SceneError::at(&text.value_span, message, expected);
        if values.len() < 2 {
            return Err(refused("too few values".into(), "expected at least two"));
        }
        if let Some(negative) = values.iter().find(|value| **value < 0.0) {
            return Err(refused(format!("{negative} is no density"), "expected numbers of at least 0"));
        }
        let largest = values.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return Err(refused("all values are 0".into(), "expected some light to be scattered"));
        }
        Ok(Self::new(values.iter().rev().map(|value| value / largest).collect()))
    }

    #[inline]
    fn density(&self, _p: DVec3, cos: f64) -> f64 {
        let last = self.knots.len() - 1;
        let place = (1.0 - cos) * (0.5 * last as f64);
        let before = (place as usize).min(last - 1);
        let [a, b] = [before, before + 1].map(|i| self.knots[i].density);
        a + (b - a) * (place - before as f64)
    }

    /// Between knots of densities a and b a share t of the way has at + ½(b − a)t² of what the knots would have
    /// with density 1. Solved for t by the root that does not cancel.
    #[inline]
    fn sample_cosine(&self, _p: DVec3, _part: f64, u: f64) -> f64 {
        let last = self.knots.len() - 1;
        let step = 2.0 / last as f64;
        // The last knot before which there is no more: never a stretch without light.
        let before = self.knots.partition_point(|knot| knot.before <= u).clamp(1, last) - 1;
        let [from, to] = [self.knots[before], self.knots[before + 1]];
        let share = (u - from.before) * (0.5 * INV_PI) / step;
        let (a, slope) = (from.density, to.density - from.density);
        let root = a + (a * a + 2.0 * slope * share).max(0.0).sqrt();
        let t = if root > 0.0 { (2.0 * share / root).min(1.0) } else { 0.0 };
        1.0 - (before as f64 + t) * step
    }
}

impl Tabulated {
    /// From densities up to a factor, from straight on to straight back.
    fn new(values: Vec<f64>) -> Self {
        let step = 2.0 / (values.len() - 1) as f64;
        let means = values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let sums = means.scan(0.0, |sum, mean| {
            *sum += mean;
            Some(*sum)
        });
        let sums: Vec<f64> = std::iter::once(0.0).chain(sums).collect();
        let all = sums[sums.len() - 1];
        let knot = |(value, sum): (f64, f64)| Knot {
            density: value / all * (0.5 * INV_PI) / step,
            before: sum / all,
        };
        Self { knots: values.into_iter().zip(sums).map(knot).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_from_backward_to_forward_as_mitsuba_has_them() {
        let phase = Tabulated::new(vec![5.0, 2.0, 1.0]);
        // `eval_pdf` of Mitsuba 3.9.1's tabphase with values 1, 2, 5.
        for (cos, expected) in
            [(1.0, 0.159155), (0.5, 0.111408), (0.0, 0.063662), (-0.5, 0.0477465), (-1.0, 0.031831)]
        {
            let density = phase.density(DVec3::ZERO, cos);
            assert!((density - expected).abs() < 1e-6, "{cos}: {density}, not {expected}");
        }
    }

    #[test]
    fn no_light_is_turned_by_angles_of_no_density() {
        let phase = Tabulated::new(vec![0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
        for i in 0..=4096 {
            let u = (f64::from(i) / 4096.0).min(1.0 - f64::EPSILON);
            let cos = phase.sample_cosine(DVec3::ZERO, 0.5, u);
            assert!((-0.75..=0.75).contains(&cos) && !(-0.249_999..-0.000_001).contains(&cos), "{u}: {cos}");
        }
    }
}
